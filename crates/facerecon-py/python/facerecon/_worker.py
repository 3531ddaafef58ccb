"""A process of a batch: reads jobs and writes rows, one JSON text per line, until stdin ends."""

import json
import sys

from ._pool import run_one

if __name__ == "__main__":
    for line in sys.stdin:
        print(json.dumps(run_one(tuple(json.loads(line)))), flush=True)
