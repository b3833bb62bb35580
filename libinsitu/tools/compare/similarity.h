#pragma once

#include <array>
#include <vector>

namespace insitu::compare {

/// CIE L*a*b* under D65, of linear sRGB primaries in [0, 1] (IEC 61966-2-1 for the matrix, CIE 15
/// for the rest). L* runs from 0 to 100.
struct Lab {
  double l = 0, a = 0, b = 0;
};
Lab lab_of_linear(double red, double green, double blue);

/// The CIEDE2000 colour difference (Sharma, Wu, Dalal, The CIEDE2000 color-difference formula:
/// implementation notes, Color Research and Application 30, 2005). About 1 can just be seen when
/// two patches lie side by side.
double delta_e_2000(const Lab& x, const Lab& y);

/// One number per pixel, row by row.
struct Plane {
  int width = 0, height = 0;
  std::vector<double> values;
};

/// Structural similarity (Wang, Bovik, Sheikh, Simoncelli, Image quality assessment: from error
/// visibility to structural similarity, IEEE Trans. Image Processing 13, 2004, section III.B-C) of
/// two planes of equal size: a Gaussian window of 11 x 11 pixels with sigma 1.5, cut and
/// renormalised at the borders, K1 = 0.01, K2 = 0.03, and `range` between the least and the largest
/// value possible. 1 means equal.
struct Similarity {
  double mean = 1;
  double lowest = 1;
  int x = 0, y = 0; ///< the centre of the lowest window
};
Similarity structural_similarity(const Plane& a, const Plane& b, double range);

} // namespace insitu::compare
