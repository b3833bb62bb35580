#pragma once

#include <vector>

inline double linear(double x, double y, double z) {
  return 1.0 + 2.0 * x - 3.0 * y + 0.5 * z;
}

/// Two hexahedra side by side along x, with a linear vertex field and a cell field.
struct Two {
  std::vector<double> x, y, z, xyz, pressure, density{10.0, 20.0};
  std::vector<int> ids{0, 1, 4, 3, 6, 7, 10, 9, 1, 2, 5, 4, 7, 8, 11, 10};
  Two() {
    for (int k = 0; k < 2; ++k)
      for (int j = 0; j < 2; ++j)
        for (int i = 0; i < 3; ++i) {
          x.push_back(i);
          y.push_back(j);
          z.push_back(k);
          for (const int c : {i, j, k})
            xyz.push_back(c);
          pressure.push_back(linear(i, j, k));
        }
  }
};
