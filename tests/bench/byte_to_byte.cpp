// Row ii: from the last sensor byte in to the actuator byte out, through the real parts (serial
// bus, frames made by the sensor, frame engine) on a pseudo-terminal, against a raw echo program on
// another one at the same time: how far from last byte + offset the byte comes out. The way of an
// event through the whole daemon: event_path.cpp.

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <iterator>
#include <list>

#include "daemon/runtime/frame_engine.h"
#include "daemon/runtime/frames.h"
#include "daemon/runtime/serial_bus.h"
#include "tests/bench/programs.h"
#include "tests/bench/realtime.h"

namespace lss::bench {
namespace {

constexpr std::size_t kPacketBytes = 18;
constexpr TimeNs kPacketPeriod = 5 * kMillisecond;  // 200 Hz
constexpr TimeNs kOffset = 4 * kMillisecond;        // before the next packet comes
constexpr TimeNs kSpin = 200 * kMicrosecond;
constexpr int kWarmUpFrames = 5;  // not counted

struct Plan {
  int frames = 0;
  std::uint32_t packets = 0;  // that make a frame
};

// A sensor that is answered with a byte, as a driver of daemon/runtime/serial_bus.h.
struct Order {
  std::uint8_t byte = 0;
};
struct Reply {
  TimeNs time_ns = 0;
};
struct Counters {
  std::uint64_t overflows = 0;
};

class PacketDriver {
 public:
  static constexpr std::size_t kMaxReplies = 1;

  explicit PacketDriver(SensorFrames* frames) noexcept : frames_(*frames) {}
  void restart(TimeNs) noexcept { bytes_ = 0; }
  void release(const Order& order, TimeNs) noexcept {
    byte_ = order.byte;
    due_ = true;
  }
  void receive(std::span<const std::uint8_t> bytes, TimeNs now) noexcept {
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      if (bytes_ == 0) first_ns_ = now;
      if (++bytes_ < kPacketBytes) continue;
      bytes_ = 0;
      frames_.packet(first_ns_);
    }
  }
  std::span<const std::uint8_t> transmit(TimeNs) noexcept {
    return std::exchange(due_, false) ? std::span<const std::uint8_t>(&byte_, 1)
                                      : std::span<const std::uint8_t>();
  }
  TimeNs next_wake() const noexcept { return INT64_MAX; }
  std::size_t take(std::span<Reply>) noexcept { return 0; }
  const Counters& counters() const noexcept { return counters_; }

 private:
  SensorFrames& frames_;
  std::size_t bytes_ = 0;
  TimeNs first_ns_ = 0;
  std::uint8_t byte_ = 0;
  bool due_ = false;
  Counters counters_;
};

// The sensor and the actuator at the far end of a terminal.
class FarEnd {
 public:
  FarEnd(const Plan& plan, TimeNs begin_ns)
      : plan_(plan),
        begin_ns_(begin_ns),
        latencies_us_(static_cast<std::size_t>(plan.frames), kNone) {}

  Terminal terminal;
  std::atomic<bool> counts{false};  // between warming up and the end

  void run() noexcept {
    const std::array<std::uint8_t, kPacketBytes> packet{};
    const int in_frame = static_cast<int>(plan_.packets);
    const int packets = (kWarmUpFrames + plan_.frames) * in_frame;
    for (int i = 0; i < packets; ++i) {
      listen(begin_ns_ + i * kPacketPeriod);
      counts = i >= kWarmUpFrames * in_frame;
      if (counts && (i + 1) % in_frame == 0) {
        asked_ns_ = now_ns();
        ++frame_;
      }
      [[maybe_unused]] const auto written = ::write(terminal.fd(), packet.data(), packet.size());
    }
    listen(begin_ns_ + packets * kPacketPeriod);
    counts = false;
  }

  TimeNs begin_ns() const { return begin_ns_; }
  // From just before the last byte of a frame was written; frames without an answer are left out.
  Samples latencies_us() const {
    Samples heard;
    for (const double latency : latencies_us_) {
      if (std::isfinite(latency)) heard.push_back(latency);
    }
    return heard;
  }

 private:
  // The first byte after a request answers it.
  void listen(TimeNs until_ns) noexcept {
    for (TimeNs now = now_ns(); now < until_ns; now = now_ns()) {
      pollfd readable{terminal.fd(), POLLIN, 0};
      const timespec timeout = to_timespec(until_ns - now);
      if (::ppoll(&readable, 1, &timeout, nullptr) <= 0) continue;
      const TimeNs heard_ns = now_ns();
      std::array<std::uint8_t, 64> bytes;
      if (::read(terminal.fd(), bytes.data(), bytes.size()) <= 0 || asked_ns_ == 0) continue;
      latencies_us_[frame_ - 1] = static_cast<double>(heard_ns - asked_ns_) * 1e-3;
      asked_ns_ = 0;
    }
  }

  Plan plan_;
  TimeNs begin_ns_;
  TimeNs asked_ns_ = 0;  // 0: nothing is asked
  std::size_t frame_ = 0;
  Samples latencies_us_;
};

constexpr TimeNs kSpins[] = {0, kSpin};  // of the chains that are measured at once

// The parts of a daemon with one sensor, on their threads.
class Chain {
 public:
  Chain(const FarEnd& far_end, const Plan& plan, TimeNs spin_ns)
      : far_end_(far_end),
        period_ns_(plan.packets * kPacketPeriod),
        frames_({.packets = plan.packets, .period_ns = period_ns_}),
        bus_(&frames_, SerialSettings{.path = far_end.terminal.name()}),
        engine_(frames_, {.period_ns = period_ns_,
                          .offset_ns = kOffset,
                          .max_consecutive_overruns = 5,
                          .actuate_spin_ns = spin_ns}) {
    deviations_ns_.reserve(static_cast<std::size_t>(plan.frames));
  }

  void start() {
    threads_.emplace_back("bus", kBusPriority, measured_cpu(), [this] { bus_.run(); });
    threads_.emplace_back("frame", kFramePriority, measured_cpu(), [this] { frame(); });
    threads_.emplace_back("actuate", kActuatePriority, measured_cpu(), [this] {
      engine_.actuate([this](const Order& order) noexcept { bus_.release(order); });
    });
  }
  void stop() {
    engine_.stop();
    threads_.pop_back();
    threads_.pop_back();
    bus_.stop();
    threads_.clear();
  }
  // After stop(): commands that were not ready at their release; releases - (T_k + offset).
  std::uint64_t overruns() const { return last_.overruns - first_.overruns; }
  std::uint64_t held() const { return last_.frames_held - first_.frames_held; }
  const std::vector<TimeNs>& deviations_ns() const { return deviations_ns_; }

 private:
  void say(const TimingPoints& timing) noexcept {
    if (!far_end_.counts) {
      if (last_.frame == 0) first_ = timing;
      return;
    }
    if (last_.frame > first_.frame && deviations_ns_.size() < deviations_ns_.capacity())
      deviations_ns_.push_back(timing.released_ns - last_.boundary_ns - kOffset);
    last_ = timing;
  }
  void frame() noexcept {
    engine_.frame(
        [](const Boundary& boundary, const Released&, TimingPoints&) noexcept {
          return Order{static_cast<std::uint8_t>(boundary.frame)};
        },
        [this](const TimingPoints& timing) noexcept { say(timing); });
  }

  const FarEnd& far_end_;
  TimeNs period_ns_;
  SensorFrames frames_;
  SerialBus<PacketDriver, SensorFrames*, Order, Reply, Counters> bus_;
  FrameEngine<SensorFrames, Order> engine_;
  TimingPoints first_, last_;  // before the measured part, and at its end
  std::vector<TimeNs> deviations_ns_;
  std::list<Fifo> threads_;
};

struct Subject {
  Samples latency_us;      // last byte in to byte out
  Samples deviation_us{};  // of that from the offset, either way
  Samples release_us{};    // of the release from T_k + offset, either way
  double late = 0;         // share of frames
  std::uint64_t held = 0;  // frames that the clock began, the sensor being late
};
struct Outcome {
  std::vector<Subject> subjects;  // as kSpins
  Samples echo_us, cyclictest_us;
};

Subject result(const FarEnd& far_end, const Chain& chain, const Plan& plan) {
  Subject s{.latency_us = far_end.latencies_us(), .held = chain.held()};
  for (const double latency : s.latency_us)
    s.deviation_us.push_back(std::abs(latency - static_cast<double>(kOffset) * 1e-3));
  for (const TimeNs deviation : chain.deviations_ns())
    s.release_us.push_back(std::abs(static_cast<double>(deviation) * 1e-3));
  const double unanswered = plan.frames - static_cast<double>(s.latency_us.size());
  s.late = std::max(unanswered, static_cast<double>(chain.overruns())) / plan.frames;
  return s;
}

// The chains, the echo and cyclictest at once.
Outcome measure(const Plan& plan) {
  const int packets = plan.frames * static_cast<int>(plan.packets);
  Folder folder;
  // Packets and answers of one fall into the gaps of the others.
  const TimeNs begin_ns = now_ns() + 300 * kMillisecond;
  std::list<FarEnd> far_ends;
  for (std::size_t i = 0; i <= std::size(kSpins); ++i) {
    const auto share = [&](TimeNs whole) {
      return whole * static_cast<TimeNs>(i) / static_cast<TimeNs>(std::size(kSpins) + 1);
    };
    far_ends.emplace_back(plan,
                          begin_ns + share(kPacketPeriod) + share(plan.packets) * kPacketPeriod);
  }
  const FarEnd& echoed = far_ends.back();
  Process echo({program("bench-pty-echo"), echoed.terminal.name(),
                std::to_string(kPacketBytes * plan.packets), std::to_string(kBusPriority),
                std::to_string(measured_cpu())},
               folder / "echo.log");
  if (!eventually([&] { return echo.said("ready"); }))
    throw NotHere("the echo program does not run");
  // At the priority of the releases, so that the chains do not delay it more than each other.
  Cyclictest cyclictest(kActuatePriority, kPacketPeriod, packets, measured_cpu(),
                        Cyclictest::Unit::microseconds);
  std::list<Chain> chains;
  {
    std::list<Fifo> hardware;
    for (const TimeNs* spin = std::begin(kSpins); FarEnd & far_end : far_ends) {
      // Just before its sensor speaks: else it begins frames by the clock, which is not meant here.
      sleep_until(far_end.begin_ns() - 3 * kMillisecond);
      if (spin != std::end(kSpins)) chains.emplace_back(far_end, plan, *spin++).start();
      hardware.emplace_back("sensor", kHardwarePriority, kHardwareCpu, [&] { far_end.run(); });
    }
  }
  for (Chain& chain : chains) chain.stop();
  Outcome outcome{
      .subjects = {}, .echo_us = echoed.latencies_us(), .cyclictest_us = cyclictest.latencies()};
  for (auto far_end = far_ends.begin(); const Chain& chain : chains)
    outcome.subjects.push_back(result(*far_end++, chain, plan));
  return outcome;
}

// Ordinary work on every CPU, for the loaded campaign.
class Load {
 public:
  explicit Load(bool wanted) {
    for (int cpu = 0; wanted && cpu <= measured_cpu(); ++cpu)
      work_.emplace_back(std::vector<std::string>{"sh", "-c", "while :; do :; done"}, "/dev/null");
  }

 private:
  std::list<Process> work_;
};

// In a machine that counts instructions no other program spreads or delays anything.
constexpr double kSigma_us = 60, kSigmaInMachine_us = 5, kMaximumInMachine = 1.2;

Figures with_offset(const Subject& s, const Outcome& outcome, const Plan& plan,
                    const std::string& how, bool maxima) {
  const std::string frames = fmt::format("{} frames of {} packets, offset {} ms", plan.frames,
                                         plan.packets, kOffset / kMillisecond);
  Figure spread = figure("ii", "byte to byte - offset" + how + ", sigma", "us",
                         side_by_side(s.latency_us, outcome.echo_us), sigma,
                         maxima ? kSigmaInMachine_us : kSigma_us);
  spread.absolute = true;
  spread.value = sigma(s.latency_us);  // of all, not of a part
  const auto over = static_cast<double>(std::ranges::count_if(
      outcome.cyclictest_us, [](double us) { return us > static_cast<double>(kOffset) * 1e-3; }));
  const auto cycles = static_cast<double>(outcome.cyclictest_us.size());
  Figures figures{
      noted(figure("ii", "byte to byte - offset" + how + ", p99", "us",
                   side_by_side(s.deviation_us, outcome.echo_us), p99, 1),
            frames + "; reference: the echo's whole way, its far end awake; ours wakes from idle"),
      noted(spread, "of all frames"),
      noted(figure("ii", "release - (T_k + offset)" + how + ", p99", "us",
                   side_by_side(s.release_us, outcome.echo_us), p99, kNone),
            "reference: the echo's whole way"),
      figure_of(
          "ii", "late frames" + how, "%", s.late * 100, over / cycles * 100, 1,
          fmt::format(
              "of {}, {} begun by the clock; reference: cyclictest later than the offset, of {}",
              plan.frames, s.held, cycles))};
  if (maxima) {
    figures.back() = to_be_none(figures.back());
    figures.push_back(most("ii", "byte to byte - offset" + how + ", max", "us",
                           side_by_side(s.deviation_us, outcome.echo_us)));
    figures.push_back(noted(most("ii", "release - (T_k + offset)" + how + ", max", "us",
                                 side_by_side(s.release_us, outcome.cyclictest_us)),
                            "reference: cyclictest"));
    figures.back().goal = kMaximumInMachine;
  }
  return figures;
}

}  // namespace

Figures byte_to_byte(const Options& options) {
  prepare_real_time();
  const bool campaign = options.campaign != Campaign::none;
  // In the deterministic machine as in the thesis, too: its time costs little.
  const Plan plan = campaign || (options.maxima && !options.quick)
                        ? Plan{.frames = 3034, .packets = 40}
                        : Plan{.frames = options.count(1000, 50), .packets = 4};
  const std::string how = options.campaign == Campaign::load ? ", loaded"
                          : campaign                         ? ", idle"
                                                             : "";
  const Load load(options.campaign == Campaign::load);

#ifdef LSS_BENCH_TALARIS
  Figures figures = event_path(options, how);
#else
  Figures figures{not_measured("ii", "byte to byte, event path" + how, "TALARIS is not built")};
#endif
  const Outcome offset = measure(plan);
  for (const auto& [index, spin] : {std::pair{0, ", asleep"}, {1, ", spin_us = 200"}}) {
    for (Figure& f : with_offset(offset.subjects[static_cast<std::size_t>(index)], offset, plan,
                                 spin + how, options.maxima))
      figures.push_back(std::move(f));
  }
#ifdef LSS_BENCH_ARDITO
  if (!campaign) std::ranges::move(sync_deviation(options), std::back_inserter(figures));
#endif
  return figures;
}

}  // namespace lss::bench
