#include "tools/lss-ground/daemons.h"

#include <algorithm>

#include "tools/lss-cli/session/wire.h"

namespace lss::ground {

void Daemons::heard(const lss_Instance& instance, Clock::time_point now) {
  if (instance.pid == 0) return;  // it does not name itself
  std::erase_if(daemons_, [&](const Daemon& d) { return now - d.heard >= kGone; });
  const auto known = std::ranges::find_if(
      daemons_, [&](const Daemon& d) { return cli::is_same(d.instance, instance); });
  if (known != daemons_.end()) {
    known->heard = now;
    return;
  }
  if (daemons_.size() >= kMost)
    daemons_.erase(std::ranges::min_element(daemons_, {}, &Daemon::heard));
  daemons_.push_back({instance, now, now});
}

std::vector<lss_Instance> Daemons::rivals(Clock::time_point now) const {
  std::vector<lss_Instance> list;
  for (const Daemon& one : daemons_) {
    if (now - one.heard >= kGone) continue;
    const bool rival = std::ranges::any_of(daemons_, [&](const Daemon& other) {
      return &other != &one && now - other.heard < kGone && other.since < one.heard &&
             one.since < other.heard;
    });
    if (rival) list.push_back(one.instance);
  }
  return list;
}

}  // namespace lss::ground
