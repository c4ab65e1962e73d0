#include "gnc/ardito/ratio.h"

#include <algorithm>

namespace lss::gnc::ardito {

double pi_step(double error, double limit, double& integral, const Parameters& p) noexcept {
  const double output = p.proportional * error + integral;
  integral = std::clamp(integral + p.integral_1_s * kFrame_s * error, -limit, limit);
  return std::clamp(output, -limit, limit);
}

}  // namespace lss::gnc::ardito
