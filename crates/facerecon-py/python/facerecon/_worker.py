"""A process of a batch: reads jobs, writes rows, one JSON text a line, until the input ends."""

import json
import sys

from ._pool import run_one

if __name__ == "__main__":
    for line in sys.stdin:
        print(json.dumps(run_one(tuple(json.loads(line)))), flush=True)
