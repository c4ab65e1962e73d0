#include "tools/lss-cli/session/ack.h"

#include <fmt/format.h>

#include <cmath>

#include "tools/lss-cli/session/status.h"
#include "tools/lss-cli/session/wire.h"

namespace lss::cli {

std::string reason_text(const lss_CommandAck& ack, const OwnCodes& own) {
  const CodeInfo* reason = info(static_cast<Reason>(ack.reason), own);
  std::string_view why = text(ack.text);
  const std::string phase = std::string(phase_name(ack.phase)) + ": ";
  if (why.starts_with(phase)) why.remove_prefix(phase.size());
  const std::string advice = std::string("; ") + (reason != nullptr ? reason->advice : "");
  if (why.ends_with(advice)) why.remove_suffix(advice.size());
  if (!why.empty()) return std::string(why);
  return reason != nullptr ? reason->text : fmt::format("reason {}", ack.reason);
}

nlohmann::json ack_json(const lss_CommandAck& ack, const OwnCodes& own) {
  const auto number = [](double value) {
    return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json();
  };
  nlohmann::json result = {{"phase", phase_name(ack.phase)},
                           {"reason", nullptr},
                           {"text", text(ack.text)},
                           {"measured", number(ack.measured)},
                           {"limit", number(ack.limit)}};
  if (ack.reason != 0) {
    const CodeInfo* reason = info(static_cast<Reason>(ack.reason), own);
    result["reason"] = {{"id", ack.reason},
                        {"name", reason != nullptr ? reason->name : ""},
                        {"advice", reason != nullptr ? reason->advice : ""}};
  }
  return result;
}

}  // namespace lss::cli
