// The DDS face as a stranger has it, and sending at a rate.

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <ctime>

#include "tests/attack/attack.h"

namespace attack {
namespace {

constexpr const char* kLoopback =
    "<General><Interfaces><NetworkInterface name=\"lo\" multicast=\"true\"/></Interfaces></General>"
    "<SharedMemory><Enable>false</Enable></SharedMemory>";
struct NamedTopic {
  const char* name;
  const dds_topic_descriptor_t* type;
};
constexpr NamedTopic kTopics[] = {{"lss/command", &lss_Command_desc},
                                  {"lss/heartbeat", &lss_Heartbeat_desc},
                                  {"lss/command_ack", &lss_CommandAck_desc},
                                  {"lss/status", &lss_Status_desc},
                                  {"lss/event", &lss_Event_desc},
                                  {"lss/stop", &lss_Command_desc},
                                  {"lss/timing", &lss_Timing_desc}};
constexpr std::int64_t kTick_ns = 1'000'000, kBehind_ns = 20'000'000;

volatile std::sig_atomic_t signalled = 0;

void sleep_until(std::int64_t ns) {
  const timespec until{.tv_sec = ns / 1'000'000'000, .tv_nsec = ns % 1'000'000'000};
  ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
}

std::string configuration() {
  const char* more = std::getenv("CYCLONEDDS_URI");
  return more == nullptr ? kLoopback : std::string(kLoopback) + "," + more;
}

dds_entity_t checked(dds_entity_t entity, const char* what) {
  if (entity > 0) return entity;
  std::fprintf(stderr, "cannot make a DDS %s: %s\n", what, dds_strretcode(-entity));
  std::exit(2);
}

}  // namespace

std::int64_t now_ns() {
  timespec t{};
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec * std::int64_t{1'000'000'000} + t.tv_nsec;
}

lss_Command command(const std::string& vehicle, const std::string& source, std::uint64_t seq,
                    std::uint16_t kind, std::uint16_t flags) {
  lss_Command sample{};
  put_text(sample.vehicle_id, vehicle);
  put_text(sample.source, source);
  sample.seq = seq;
  sample.kind = kind;
  sample.flags = flags;
  return sample;
}

lss_Heartbeat heartbeat(const std::string& vehicle, const std::string& source,
                        std::uint64_t counter) {
  lss_Heartbeat sample{};
  put_text(sample.vehicle_id, vehicle);
  put_text(sample.source, source);
  sample.counter = counter;
  return sample;
}

Wire::Wire(dds_domainid_t domain)
    : domain_(checked(dds_create_domain(domain, configuration().c_str()), "domain")),
      participant_(checked(dds_create_participant(domain, nullptr, nullptr), "participant")) {}

Wire::~Wire() { dds_delete(domain_); }

dds_entity_t Wire::topic(Topic topic) {
  const auto& [name, type] = kTopics[static_cast<int>(topic)];
  return dds_create_topic(participant_, type, name, nullptr, nullptr);
}

dds_entity_t Wire::writer(Topic which, bool wait) {
  const dds_entity_t made = checked(try_writer(which), "writer");
  if (wait) wait_for(participant_, made, DDS_PUBLICATION_MATCHED_STATUS, "no daemon reads");
  return made;
}

dds_entity_t Wire::try_writer(Topic which, bool as_daemon) {
  dds_qos_t* qos = dds_create_qos();
  if (which == Topic::heartbeat) {
    dds_qset_reliability(qos, DDS_RELIABILITY_BEST_EFFORT, 0);
  } else {  // never waits for a reader that is slow
    dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, 0);
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 128);
  }
  if (as_daemon && which != Topic::heartbeat) {
    dds_qset_deadline(qos, DDS_SECS(10));
    if (which == Topic::status || which == Topic::event)
      dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
  }
  const dds_entity_t on = topic(which);
  const dds_entity_t made = on > 0 ? dds_create_writer(participant_, on, qos, nullptr) : on;
  dds_delete_qos(qos);
  return made == DDS_RETCODE_NOT_ALLOWED_BY_SECURITY ? 0 : made;
}

dds_entity_t Wire::reader(Topic which, const dds_qos_t* qos) {
  const dds_entity_t made = dds_create_reader(participant_, topic(which), qos, nullptr);
  return made == DDS_RETCODE_NOT_ALLOWED_BY_SECURITY ? 0 : checked(made, "reader");
}

void wait_for(dds_entity_t participant, dds_entity_t entity, std::uint32_t status,
              const char* what) {
  const dds_entity_t waitset = checked(dds_create_waitset(participant), "waitset");
  dds_set_status_mask(entity, status);
  dds_waitset_attach(waitset, entity, 0);
  dds_attach_t triggered;
  const dds_return_t came = dds_waitset_wait(waitset, &triggered, 1, DDS_SECS(20));
  dds_delete(waitset);
  if (came > 0) return;
  std::fprintf(stderr, "%s within 20 s: check the domain\n", what);
  std::exit(1);
}

void Counts::put_out() const {
  std::printf("{\"mode\": \"%s\"", mode_.c_str());
  for (const auto& [name, value] : numbers_) std::printf(", \"%s\": %.10g", name.c_str(), value);
  for (const auto& [name, value] : times_) {
    if (value == 0) {
      std::printf(", \"%s\": null", name.c_str());
    } else {
      std::printf(", \"%s\": %lld", name.c_str(), static_cast<long long>(value));
    }
  }
  std::printf("}\n");
  std::fflush(stdout);
}

void say_ready() { std::fprintf(stderr, "ready\n"); }

bool ended() {
  static const bool listening = [] {
    for (const int number : {SIGINT, SIGTERM}) std::signal(number, [](int) { signalled = 1; });
    return true;
  }();
  return listening && signalled != 0;
}

void at_rate(const Options& options, Counts& counts,
             const std::function<dds_return_t(std::uint64_t)>& send) {
  std::uint64_t sent = 0, refused = 0, left_out = 0;
  const auto interval_ns = static_cast<std::int64_t>(1e9 / options.rate);
  const std::int64_t begin_ns = now_ns();
  const std::int64_t end_ns = begin_ns + static_cast<std::int64_t>(options.seconds * 1e9);
  std::int64_t due_ns = begin_ns;  // of the next message
  say_ready();
  while (!ended()) {
    const std::int64_t now = now_ns();
    if (now >= end_ns) break;
    if (now - due_ns > kBehind_ns) {
      const std::int64_t skipped = (now - due_ns - kBehind_ns) / interval_ns;
      left_out += static_cast<std::uint64_t>(skipped);
      due_ns += skipped * interval_ns;
    }
    for (; due_ns <= now; due_ns += interval_ns) {
      if (send(sent + refused) == DDS_RETCODE_OK) {
        ++sent;
      } else {
        ++refused;
      }
    }
    sleep_until(std::min(std::max(due_ns, now + kTick_ns), end_ns));
  }
  const double seconds = static_cast<double>(now_ns() - begin_ns) * 1e-9;
  counts.add("sent", static_cast<double>(sent));
  counts.add("refused", static_cast<double>(refused));
  counts.add("left_out", static_cast<double>(left_out));
  counts.add("seconds", seconds);
  counts.add("per_second", static_cast<double>(sent) / seconds);
}

}  // namespace attack
