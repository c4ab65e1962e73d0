// The state and bit rate of a CAN interface, asked from the kernel by netlink.

#include <linux/can/netlink.h>
#include <linux/if.h>
#include <linux/if_link.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <sys/socket.h>
#include <sys/time.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "drivers/file.h"
#include "tools/lss-cli/doctor/probes.h"

namespace lss::cli::doctor {
namespace {

using Bytes = std::span<const std::byte>;

template <class T>
std::optional<T> read_as(Bytes bytes) {
  if (bytes.size() < sizeof(T)) return std::nullopt;
  T value{};
  std::memcpy(&value, bytes.data(), sizeof value);
  return value;
}

// Calls visit(type, content) for each attribute; stops at the first malformed one.
template <class Visit>
void for_each_attribute(Bytes bytes, Visit visit) {
  while (const std::optional<rtattr> head = read_as<rtattr>(bytes)) {
    if (head->rta_len < sizeof(rtattr) || head->rta_len > bytes.size()) return;
    visit(head->rta_type & NLA_TYPE_MASK,
          bytes.subspan(sizeof(rtattr), head->rta_len - sizeof(rtattr)));
    bytes = bytes.subspan(std::min<std::size_t>(bytes.size(), RTA_ALIGN(head->rta_len)));
  }
}

void read_can(Bytes attributes, CanLink& link) {
  for_each_attribute(attributes, [&](int type, Bytes content) {
    if (type == IFLA_CAN_STATE) link.state = read_as<std::uint32_t>(content);
    if (type == IFLA_CAN_BITTIMING)
      link.bitrate = read_as<can_bittiming>(content).value_or(can_bittiming{}).bitrate;
    if (type == IFLA_CAN_RESTART_MS) link.restart_ms = read_as<std::uint32_t>(content).value_or(0);
  });
}

class Socket {
 public:
  Socket() {
    const timeval patience{.tv_sec = 1, .tv_usec = 0};
    ::setsockopt(file_.get(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  }

  // The number of bytes of the answer; 0 when none came.
  std::size_t ask(Bytes question, std::span<std::byte> answer) const {
    if (::send(file_.get(), question.data(), question.size(), 0) < 0) return 0;
    const ssize_t size = ::recv(file_.get(), answer.data(), answer.size(), 0);
    return size > 0 ? static_cast<std::size_t>(size) : 0;
  }

 private:
  File file_{::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE)};
};

}  // namespace

CanLink parse_can_link(Bytes attributes) {
  CanLink link;
  for_each_attribute(attributes, [&](int type, Bytes info) {
    if (type != IFLA_LINKINFO) return;
    for_each_attribute(info, [&](int inner, Bytes content) {
      if (inner == IFLA_INFO_KIND) {
        const std::string_view kind(reinterpret_cast<const char*>(content.data()), content.size());
        link.kind = kind.substr(0, kind.find('\0'));
      }
      if (inner == IFLA_INFO_DATA && link.kind == "can") read_can(content, link);
    });
  });
  return link;
}

std::optional<CanLink> ask_can_link(const std::string& interface) {
  struct {
    nlmsghdr head{};
    ifinfomsg about{};
    rtattr name{};
    char text[IFNAMSIZ] = {};
  } question;
  if (interface.empty() || interface.size() >= sizeof question.text) return std::nullopt;
  interface.copy(question.text, sizeof question.text - 1);
  question.name = {.rta_len = static_cast<unsigned short>(sizeof(rtattr) + interface.size() + 1),
                   .rta_type = IFLA_IFNAME};
  question.head.nlmsg_type = RTM_GETLINK;
  question.head.nlmsg_flags = NLM_F_REQUEST;
  question.head.nlmsg_len =
      static_cast<std::uint32_t>(sizeof(nlmsghdr) + sizeof(ifinfomsg)) + question.name.rta_len;
  question.about.ifi_family = AF_UNSPEC;

  std::array<std::byte, 32768> buffer{};
  const Bytes sent = std::as_bytes(std::span(&question, 1)).first(question.head.nlmsg_len);
  const Bytes answer = Bytes(buffer).first(Socket().ask(sent, buffer));
  const std::optional<nlmsghdr> head = read_as<nlmsghdr>(answer);
  constexpr std::size_t kBefore = sizeof(nlmsghdr) + sizeof(ifinfomsg);
  if (!head || head->nlmsg_type != RTM_NEWLINK || head->nlmsg_len > answer.size() ||
      head->nlmsg_len < kBefore) {
    return std::nullopt;
  }
  return parse_can_link(answer.subspan(kBefore, head->nlmsg_len - kBefore));
}

}  // namespace lss::cli::doctor
