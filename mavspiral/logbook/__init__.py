"""What was flown: measured, held against the plan, and kept while it goes on."""
