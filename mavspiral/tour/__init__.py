"""From home along one pass after another and back: the passes, the ways between, and what one battery flies of them."""
