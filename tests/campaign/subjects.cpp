#include "tests/campaign/campaign.h"

namespace lss::campaign {

std::span<const Subject> subjects() {
  static const std::vector<Subject> all = {
#ifdef LSS_CAMPAIGN_ZEBRO
      zebro(),
#endif
#ifdef LSS_CAMPAIGN_ARDITO
      ardito(),
#endif
#ifdef LSS_CAMPAIGN_TALARIS
      talaris(),
#endif
  };
  return all;
}

}  // namespace lss::campaign
