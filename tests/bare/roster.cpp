#include "tools/lss-cli/session/vehicle.h"

namespace lss::cli {
std::span<const Overlay* const> overlays() { return {}; }
std::vector<std::string> built_dictionaries() { return {}; }
}  // namespace lss::cli
