# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

petzval = (getattr(bpy.context, "camera", None) or bpy.context.scene.camera.data).petzval

petzval.lens_file = "reflex-nikkor-500-f8.lens"
petzval.model = "LENS"
petzval.focal_mode = "PUBLISHED"
petzval.focal_length = 50.0
petzval.focal_scale = 1.0
petzval.wide_open = True
petzval.f_number = 5.6
petzval.pupil_diameter = 0.0
petzval.blades = 0
petzval.blade_rotation = 0.0
petzval.blade_curvature = 0.0
petzval.glare_roughness = 2.0
petzval.glare_cleanliness = 300.0
petzval.glare_veil = 0.01
petzval.coating = "AS_FILE"
petzval.exposes_by_f_number = False
petzval.white_balance = True
petzval.spectrum = "VISIBLE"
petzval.wavelength = 587.5618
petzval.precision = "AUTO"
