"""The loop that flies whole flights in lockstep is beside the tests."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
