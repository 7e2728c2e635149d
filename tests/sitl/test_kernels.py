import shutil
import subprocess
import sys
from pathlib import Path

import sitl.kernels

CALLER = """
from rooms.kernels import kernel
from rooms.callee import answer

@kernel
def ask():
    return answer()

if __name__ == "__main__":
    print(ask())
    print(len(list(ask.stats.cache_hits)))
"""
CALLEE = """
from rooms.kernels import kernel

@kernel
def answer():
    return {}
"""


def test_a_change_in_another_rooms_callee_is_seen_and_the_same_code_is_not_compiled_again(tmp_path: Path):
    rooms = tmp_path / "rooms"
    rooms.mkdir()
    (rooms / "__init__.py").touch()
    shutil.copy(sitl.kernels.__file__, rooms / "kernels.py")
    (rooms / "caller.py").write_text(CALLER)

    def ask(answer: int) -> list[str]:
        (rooms / "callee.py").write_text(CALLEE.format(answer))
        run = subprocess.run(
            [sys.executable, "-m", "rooms.caller"], cwd=tmp_path, capture_output=True, text=True, check=True
        )
        return run.stdout.split()

    assert ask(1) == ["1", "0"]
    assert ask(1) == ["1", "1"]
    assert ask(2) == ["2", "0"]


def test_filterpy_is_imported_only_by_whoever_flies():
    code = "import sys, sitl.vehicle; sys.exit('filterpy' in sys.modules)"
    root = Path(sitl.kernels.__file__).parents[1]
    assert subprocess.run([sys.executable, "-c", code], cwd=root, check=False).returncode == 0
