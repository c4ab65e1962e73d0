#include "gnc/zebro/stability.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "gnc/math.h"

namespace lss::gnc::zebro {

double static_margin_m(const PerLeg<bool>& in_stance, const PerLeg<double>& theta_rad,
                       double diameter_m, const HipGeometry& hips) noexcept {
  PerLeg<double> x_m{};
  PerLeg<double> y_m{};
  std::size_t feet = 0;
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (!in_stance[i]) continue;
    x_m[feet] = hips.x_m[i] + contact_offset_m(theta_rad[i], diameter_m);
    y_m[feet] = hips.y_m[i];
    ++feet;
  }
  if (feet < 2) return -std::numeric_limits<double>::infinity();

  // An edge of the convex hull has every other foot on its left; for so few feet, trying all pairs
  // is simplest.
  double margin_m = std::numeric_limits<double>::infinity();
  for (std::size_t a = 0; a < feet; ++a) {
    for (std::size_t b = 0; b < feet; ++b) {
      const double dx_m = x_m[b] - x_m[a];
      const double dy_m = y_m[b] - y_m[a];
      if (dx_m == 0 && dy_m == 0) continue;
      const auto left_of_edge = [&](double px_m, double py_m) {  // times the edge's length
        return dx_m * (py_m - y_m[a]) - dy_m * (px_m - x_m[a]);
      };
      constexpr double kRounding_m = 1e-12;
      const double rounding = -kRounding_m * (std::abs(dx_m) + std::abs(dy_m));
      bool edge = true;
      for (std::size_t c = 0; c < feet && edge; ++c) {
        edge = left_of_edge(x_m[c], y_m[c]) >= rounding;
      }
      if (edge) margin_m = std::min(margin_m, left_of_edge(0, 0) / math::hypot(dx_m, dy_m));
    }
  }
  return margin_m;
}

}  // namespace lss::gnc::zebro
