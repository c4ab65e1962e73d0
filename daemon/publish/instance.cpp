#include "daemon/publish/instance.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <fstream>
#include <string>
#include <string_view>

#include "daemon/publish/convert.h"
#include "daemon/runtime/clock.h"

namespace lss::dds {
namespace {

// The first 64 bits of /proc/sys/kernel/random/boot_id; 0 when there is none.
std::uint64_t boot() {
  std::string id;
  std::ifstream("/proc/sys/kernel/random/boot_id") >> id;
  std::erase(id, '-');
  id.resize(std::min<std::size_t>(id.size(), 16));
  std::uint64_t value = 0;
  std::from_chars(id.data(), id.data() + id.size(), value, 16);
  return value;
}

}  // namespace

lss_Instance this_instance() {
  lss_Instance instance{};
  instance.boot = boot();
  instance.started_utc_ns = utc_ns();
  instance.pid = static_cast<std::int32_t>(::getpid());
  std::array<char, 256> host{};
  if (::gethostname(host.data(), host.size() - 1) == 0)
    copy_text(std::string_view(host.data()), instance.host);
  return instance;
}

bool is_same(const lss_Instance& a, const lss_Instance& b) noexcept {
  return a.boot == b.boot && a.started_utc_ns == b.started_utc_ns && a.pid == b.pid &&
         read_text(a.host) == read_text(b.host);
}

}  // namespace lss::dds
