# SPDX-License-Identifier: GPL-3.0-or-later
"""The closing lines of `make demo`: demo-report.py IMAGE STATS.json"""

import json
import sys
from pathlib import Path

image, statistics = map(Path, sys.argv[1:])
stats = json.loads(statistics.read_text())
lost = stats["camera_rays_lost"] / max(stats["camera_rays"], 1)
print(f"image       {image}")
print(f"resolution  {stats['width']} x {stats['height']}")
print(f"samples     {stats['samples']}")
print(f"seconds     {sum(value or 0.0 for value in stats['seconds'].values()):.1f}")
print(f"processor   {stats['processor']}")
print(f"lens        {stats['lens']}")
print(f"lost        {100.0 * lost:.2f} % of the camera rays")
