"""Add this machine's `ecs-eco doctor` self-test results to the release's digests.

    python tools/release_digests.py [--only]

Adds or updates the digests of this machine's target. If results have changed, the digests of other targets
are invalid: `--only` removes them.
"""

import argparse
import json
import sys

from ecs_eco import __version__
from ecs_eco.testing.self_test import DIGESTS, cases, examine_all
from ecs_eco.testing.target import target


def main() -> int:
    """Run the self-test; write its digests if it passes."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--only", action="store_true", help="remove the digests of other targets")
    only = parser.parse_args().only
    here = target()
    outcomes = examine_all(
        cases(), lambda done, total: print(f"{done} of {total}", end="\r", file=sys.stderr)
    )
    if failed := [outcome.case.name for outcome in outcomes if not outcome.holds]:
        print(
            f"not written, because threads or checkpoints change results on this machine: {'; '.join(failed)}",
            file=sys.stderr,
        )
        return 1
    kept = {} if only or not DIGESTS.is_file() else json.loads(DIGESTS.read_text(encoding="utf-8"))["targets"]
    kept[here.key] = {
        "target": here._asdict(),
        "digests": {outcome.case.name: outcome.digest for outcome in outcomes},
    }
    DIGESTS.write_text(
        json.dumps({"release": __version__, "targets": dict(sorted(kept.items()))}, indent=1) + "\n",
        encoding="utf-8",
    )
    print(f"{DIGESTS.name}: {here.key}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
