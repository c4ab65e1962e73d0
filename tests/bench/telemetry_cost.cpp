// Row iv: cost of telemetry for the frame thread, against a copy of the sample and against writing
// it to DDS; and the way from the frame thread of the real daemon to a subscriber, against a
// program in C that writes to a listener. By the network; the way by shared memory needs a RouDi.
// Then the daemon's releases with subscribers, against those without.

#include <fmt/format.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstring>
#include <iterator>
#include <map>
#include <mutex>

#include "daemon/runtime/clock.h"
#include "daemon/runtime/latest.h"
#include "idl/topics.h"
#include "tests/bench/programs.h"
#include "tests/bench/realtime.h"
#include "zebro.h"

namespace lss::bench {
namespace {

dds::Topic telemetry_topic() { return dds::telemetry_topic("zebro", &lss_ZebroTelemetry_desc); }

// Time of one call, from many.
template <class Call>
Samples call_ns(int calls, Call&& call) {
  const TimeNs begin = now_ns();
  for (int i = 0; i < calls; ++i) call(i);
  return {static_cast<double>(now_ns() - begin) / calls};
}

// The compiler must not remove this write.
void keep(const void* memory) { asm volatile("" : : "r"(memory) : "memory"); }

Figures cost(const Options& options) {
  Folder folder;
  const int echo_domain = domain(3);
  const Process reader({program("bench-dds-echo"), std::to_string(echo_domain)},
                       folder / "echo.log", {loopback()});
  const dds::Participant participant = value(dds::Participant::create({.domain = echo_domain}));
  const dds::Entity writer = value(dds::create_writer(participant.get(), telemetry_topic()));
  const auto matched = [&] {
    dds_publication_matched_status_t status;
    return dds_get_publication_matched_status(writer.get(), &status) == DDS_RETCODE_OK &&
           status.current_count > 0;
  };
  if (!eventually(matched)) throw NotHere("no DDS reader is found on loopback");

  lss_ZebroTelemetry sample{}, copy{}, wire{};
  Latest<lss_ZebroTelemetry> latest;
  const int wake_fd = ::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  const int calls = options.count(200'000, 20'000), writes = options.count(2'000, 200);
  const auto put = [&](int i) {
    sample.frame = static_cast<std::uint64_t>(i);
    latest.put(sample);
    keep(&latest);
  };
  const auto put_and_wake = [&](int i) {
    put(i);
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = ::write(wake_fd, &one, sizeof one);
  };
  const auto memcpy_ns = [&] {
    return call_ns(calls, [&](int i) {
      sample.frame = static_cast<std::uint64_t>(i);
      keep(&sample);
      std::memcpy(&copy, &sample, sizeof sample);
      keep(&copy);
    });
  };
  const auto write_ns = [&] {
    return call_ns(writes, [&](int i) {
      wire.frame = static_cast<std::uint64_t>(i);
      dds_write(writer.get(), &wire);
    });
  };
  const std::string size = std::to_string(sizeof sample) + " bytes";
  Figures figures{
      noted(figure("iv", "telemetry put, against memcpy", "ns",
                   turn_by_turn([&] { return call_ns(calls, put); }, memcpy_ns), median, 2),
            size),
      figure("iv", "telemetry put, against dds_write", "ns",
             turn_by_turn([&] { return call_ns(calls, put); }, write_ns), median, 1 / 40.0),
      noted(figure("iv", "put and wake, against dds_write", "ns",
                   turn_by_turn([&] { return call_ns(calls, put_and_wake); }, write_ns), median,
                   1 / 40.0),
            "wake: one system call a frame, for telemetry, timing and answers")};
  figures.back().held_back = "the system call, which a put does not need";
  ::close(wake_fd);
  return figures;
}

// Listens on one domain: when samples of telemetry and, from the daemon, of timing came.
class Subscriber {
 public:
  explicit Subscriber(int domain)
      : participant_(value(dds::Participant::create({.domain = domain}))),
        telemetry_(reader(
            telemetry_topic(),
            [](dds_entity_t r, void* self) { static_cast<Subscriber*>(self)->on_telemetry(r); })),
        timing_(reader(dds::common_topic(dds::Kind::timing), [](dds_entity_t r, void* self) {
          static_cast<Subscriber*>(self)->on_timing(r);
        })) {}

  void clear() {
    const std::lock_guard lock(mutex_);
    frames_.clear();
  }
  // From `time_ns` in the sample itself.
  Samples since_written_us() {
    return collect([](const Frame& f) { return f.heard_ns != 0 ? f.heard_ns - f.written_ns : -1; });
  }
  // Of commands, after T_k + offset.
  Samples released_us() {
    return collect([](const Frame& f) {
      return f.released_ns != 0 && f.due_ns != 0 ? f.released_ns - f.due_ns : -1;
    });
  }
  // From the end of the frame's computation, as its timing points say.
  Samples since_ready_us() {
    return collect([](const Frame& f) {
      return f.heard_ns != 0 && f.ready_ns != 0 ? f.heard_ns - f.ready_ns : -1;
    });
  }

 private:
  struct Frame {
    TimeNs heard_ns = 0, written_ns = 0, ready_ns = 0, due_ns = 0, released_ns = 0;
  };

  dds::Entity reader(const dds::Topic& topic, dds_on_data_available_fn function) {
    dds_listener_t* listener = dds_create_listener(this);
    dds_lset_data_available(listener, function);
    dds::Entity entity =
        value(dds::create_reader(participant_.get(), topic, dds::Transport::best, listener));
    dds_delete_listener(listener);
    return entity;
  }
  void on_telemetry(dds_entity_t reader) {
    const TimeNs now = now_ns();
    lss_ZebroTelemetry sample;
    void* pointer = &sample;
    dds_sample_info_t info;
    while (dds_take(reader, &pointer, &info, 1, 1) > 0) {
      const std::lock_guard lock(mutex_);
      frames_[sample.frame].heard_ns = now;
      frames_[sample.frame].written_ns = sample.time_ns;
    }
  }
  void on_timing(dds_entity_t reader) {
    lss_Timing sample;
    void* pointer = &sample;
    dds_sample_info_t info;
    while (dds_take(reader, &pointer, &info, 1, 1) > 0) {
      const std::lock_guard lock(mutex_);
      Frame& frame = frames_[sample.frame];
      frame.ready_ns = sample.ready_ns;
      frame.due_ns = sample.boundary_ns + sample.offset_ns;
      if (sample.frame > 0) frames_[sample.frame - 1].released_ns = sample.released_ns;
    }
  }
  template <class Age>
  Samples collect(Age&& age) {
    const std::lock_guard lock(mutex_);
    Samples samples;
    for (const auto& [number, frame] : frames_) {
      if (const TimeNs ns = age(frame); ns > 0) samples.push_back(static_cast<double>(ns) * 1e-3);
    }
    return samples;
  }

  std::mutex mutex_;
  std::map<std::uint64_t, Frame> frames_;
  dds::Participant participant_;
  dds::Entity telemetry_, timing_;  // last: destroyed before the data of their listeners
};

Figure end_to_end(const Options& options) {
  const int daemon_domain = domain(4), raw_domain = domain(5);
  Folder folder;
  std::optional<Daemon> daemon;
  std::optional<Process> raw;
  {
    const OnCpu writers(measured_cpu());
    daemon.emplace(daemon_domain, false);
    raw.emplace(
        std::vector<std::string>{program("bench-dds-writer"), std::to_string(raw_domain), "20000"},
        folder / "writer.log", Process::Environment{loopback()});
  }
  const OnCpu subscribers(kHardwareCpu);
  Subscriber from_daemon(daemon_domain), from_raw(raw_domain);
  const std::size_t samples = static_cast<std::size_t>(options.count(1000, 50));
  if (!eventually([&] {
        return from_daemon.since_ready_us().size() > 5 && from_raw.since_written_us().size() > 5;
      }))
    throw NotHere("no telemetry is heard on loopback");
  from_daemon.clear();
  from_raw.clear();
  eventually([&] { return from_daemon.since_ready_us().size() >= samples; },
             std::chrono::seconds(60));
  return noted(
      figure("iv", "telemetry, frame thread to subscriber, p50", "us",
             side_by_side(from_daemon.since_ready_us(), from_raw.since_written_us()), median, 1.25),
      "by the network; reference: the same sample, dds_write to listener");
}

// As many subscribers of telemetry, each a participant of its own in this process.
class Crowd {
 public:
  Crowd(int domain, int count) {
    for (int i = 0; i < count; ++i) {
      participants_.push_back(value(dds::Participant::create({.domain = domain})));
      readers_.push_back(value(dds::create_reader(participants_.back().get(), telemetry_topic())));
    }
  }

 private:
  std::vector<dds::Participant> participants_;
  std::vector<dds::Entity> readers_;
};

// Releases while others listen.
Figures releases(const Options& options) {
  const int daemon_domain = domain(7);
  Folder folder;
  std::optional<Daemon> daemon;
  {
    const OnCpu subject(measured_cpu());
    daemon.emplace(daemon_domain, false);
  }
  const OnCpu listeners(kHardwareCpu);
  Subscriber timing(daemon_domain);
  const auto frames = static_cast<std::size_t>(options.count(150, 20));
  const auto released_us = [&] {
    timing.clear();
    if (!eventually([&] { return timing.released_us().size() >= frames; },
                    std::chrono::seconds(60)))
      throw NotHere("the daemon's timing is not heard on loopback");
    return timing.released_us();
  };
  const auto compared = [&](const std::string& with, const std::function<Samples()>& subject) {
    return noted(figure("iv", "release - (T_k + offset) with " + with + ", p99", "us",
                        turn_by_turn(subject, released_us, options.count(kRounds, 1)), p99, 1),
                 "reference: without");
  };
  Figures figures;
  for (const int count : {1, 8, 64}) {
    figures.push_back(
        compared(fmt::format("{} subscriber{}", count, count == 1 ? "" : "s"), [&, count] {
          const Crowd crowd(daemon_domain, count);
          return released_us();
        }));
  }
  figures.push_back(compared("lss-ros", [&] {
    Process ros({program("lss-ros"), "--domain", std::to_string(daemon_domain)},
                folder / "ros.log");
    if (!eventually([&] { return ros.said("on ROS domain"); }, std::chrono::seconds(60)))
      throw std::runtime_error("lss-ros does not start: " + read_file(folder / "ros.log"));
    Samples released = released_us();
    ros.signal(SIGINT);
    ros.wait();
    return released;
  }));
  return figures;
}

}  // namespace

Figures telemetry_cost(const Options& options) {
  Figures figures = cost(options);
  figures.push_back(end_to_end(options));
  std::ranges::move(releases(options), std::back_inserter(figures));
  return figures;
}

}  // namespace lss::bench
