// SPDX-License-Identifier: GPL-3.0-or-later
// Asks lensfun for the calibrations of a lens and what they make of points. tools/reference-lensfun.sh compiles it with lensfun's own
// source, in which every float was made a double.
//
// driver DATABASE.xml MODEL CROP FOCAL_MM F_NUMBER DISTANCE_M: a JSON object; lengths in mm on the sensor, from the middle.
#include "config.h"
#include "lensfun.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

int main(int count, char **given)
{
    lfDatabase database;
    if (count != 7 || database.Load(given[1]) != LF_NO_ERROR)
        return 1;
    double crop = atof(given[3]), focal = atof(given[4]), f_number = atof(given[5]), distance = atof(given[6]);
    const lfLens *lens = NULL;
    for (const lfLens *const *all = database.GetLenses(); *all; all++)
        if (!strcmp((*all)->Model, given[2]))
            lens = *all;
    if (!lens)
        return 2;
    lfLensCalibDistortion distortion;
    lfLensCalibTCA colour;
    lfLensCalibVignetting vignetting;
    bool has_distortion = lens->InterpolateDistortion(crop, focal, distortion);
    bool has_colour = lens->InterpolateTCA(crop, focal, colour);
    bool has_vignetting = lens->InterpolateVignetting(crop, focal, f_number, distance, vignetting);
    printf("{\"model\": \"%s\", \"crop\": %.17g, \"focal_mm\": %.17g, \"f_number\": %.17g, \"distance_m\": %.17g", given[2], crop, focal,
           f_number, distance);
    if (has_distortion)
        printf(", \"real_focal_mm\": %.17g", distortion.RealFocal);
    const int width = 6001, height = 4001;
    lfModifier modifier(lens, focal, crop, width, height, LF_PF_F64, false);
    modifier.EnableDistortionCorrection();
    modifier.EnableTCACorrection();
    modifier.EnableVignettingCorrection(f_number, distance);
    const double pixel_mm = hypot(36.0, 24.0) / crop / hypot(width, height);
    const double middle_x = (width - 1) / 2.0, middle_y = (height - 1) / 2.0;
    printf(", \"points\": [");
    for (int i = 0; i < 5; i++) {
        // From beside the middle to the corner; none on a line through it.
        double x = middle_x + (0.05 + i * 0.95 / 4.0) * middle_x;
        double y = middle_y - (0.02 + i * 0.9 / 4.0) * middle_y;
        double place[2], places[6], light = 1.0;
        printf("%s{\"at_mm\": [%.17g, %.17g]", i ? ", " : "", (x - middle_x) * pixel_mm, (y - middle_y) * pixel_mm);
        if (has_distortion && modifier.ApplyGeometryDistortion(x, y, 1, 1, place))
            printf(", \"distorted_mm\": [%.17g, %.17g]", (place[0] - middle_x) * pixel_mm, (place[1] - middle_y) * pixel_mm);
        if (has_colour && modifier.ApplySubpixelDistortion(x, y, 1, 1, places))
            printf(", \"red_mm\": [%.17g, %.17g], \"blue_mm\": [%.17g, %.17g]", (places[0] - middle_x) * pixel_mm,
                   (places[1] - middle_y) * pixel_mm, (places[4] - middle_x) * pixel_mm, (places[5] - middle_y) * pixel_mm);
        if (has_vignetting) {
            modifier.ApplyColorModification(&light, x, y, 1, 1, LF_CR_1(INTENSITY), 8);
            printf(", \"gain\": %.17g", light);
        }
        printf("}");
    }
    printf("]}\n");
    return 0;
}
