# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

petzval = bpy.context.scene.petzval

petzval.samples = 65536
petzval.use_noise_threshold = False
petzval.noise_threshold = 0.01
petzval.min_samples = 0
petzval.use_blue_noise = True
petzval.time_limit = 60.0
