# SPDX-License-Identifier: GPL-3.0-or-later
"""Render > Render on Farm: the operator, as it runs without a window."""

from __future__ import annotations

import http.server
import json
import shutil
import threading

import pytest

from support.exr_bytes import assert_same_picture

pytestmark = pytest.mark.once


def test_on_this_machine(blender, farm_scenes_folder, commands, tmp_path):
    """What is rendered is what the command renders, and the picture is there; the same folder goes on."""
    scene = tmp_path / "small.blend"
    shutil.copytree(farm_scenes_folder.parents[1], tmp_path / "work")
    scene = tmp_path / "work/shots/scene/small.blend"
    blender.ops.wm.open_mainfile(filepath=str(scene))
    done = blender.ops.petzval.render_on_farm(engine="LOCAL", folder=str(tmp_path / "job"), parts=2, at_a_time=2)
    assert done == {"FINISHED"}
    (whole,) = commands(["render", scene, "--passes", "-o", tmp_path / "whole.exr"])
    assert whole.returncode == 0, whole.stderr
    picture = tmp_path / "job/pictures/small.exr"
    assert_same_picture(picture, tmp_path / "whole.exr")
    assert [one.filepath for one in blender.data.images if one.filepath == str(picture)]
    before = picture.stat().st_mtime_ns
    assert blender.ops.petzval.render_on_farm(engine="LOCAL", folder=str(tmp_path / "job"), parts=2) == {"FINISHED"}
    assert picture.stat().st_mtime_ns == before


def test_what_cannot_be_rendered_is_said(blender, parts, tmp_path):
    parts.set_up()
    with pytest.raises(RuntimeError, match="never saved"):
        blender.ops.petzval.render_on_farm(folder=str(tmp_path / "job"))
    blender.context.scene.camera = None
    blender.ops.wm.save_as_mainfile(filepath=str(tmp_path / "none.blend"))
    with pytest.raises(RuntimeError, match="no camera in scene"):
        blender.ops.petzval.render_on_farm(folder=str(tmp_path / "job"))
    assert not (tmp_path / "job").exists()


def test_flamenco_is_handed_the_job(blender, job):
    """By the call that its add-on makes, to a Manager that is imitated."""
    farming = __import__("petzval_addon.render.farming", fromlist=["FarmRun"])
    heard = []

    class Manager(http.server.BaseHTTPRequestHandler):
        def do_POST(self):
            heard.append((self.path, json.loads(self.rfile.read(int(self.headers["Content-Length"])))))
            self.send_response(200 if len(heard) == 1 else 422)
            self.end_headers()
            self.wfile.write(b"job type is unknown")

        def log_message(self, *_):
            pass

    server = http.server.HTTPServer(("127.0.0.1", 0), Manager)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    address = f"http://127.0.0.1:{server.server_port}"
    asked = farming.Asked(["false"], {}, [], "x.blend", job, "FLAMENCO", 3, address=address)
    farming.FarmRun(asked).advance()
    (path, told) = heard[0]
    assert path == "/api/v3/jobs" and told["type"] == "petzval-farm"
    assert told["settings"]["job_folder"] == str(job) and told["settings"]["part_count"] == 3
    with pytest.raises(farming.FarmError, match="job type is unknown"):
        farming.FarmRun(asked).advance()
    server.shutdown()
    asked.address = "manager"
    with pytest.raises(farming.FarmError, match="name the Manager"):
        farming.FarmRun(asked).advance()
