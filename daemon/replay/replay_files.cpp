#include "daemon/replay/replay_files.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <ctime>

#include "daemon/record/recording.h"
#include "daemon/replay/records.h"
#include "daemon/runtime/clock.h"

namespace lss::record {
namespace {

using Reader = RecordingReader;
namespace fs = std::filesystem;

std::string text(const nlohmann::ordered_json& header, const char* key) {
  return header.contains(key) && header[key].is_string() ? header[key].get<std::string>() : "";
}

// Saved parameters at the start of the daemon, which replaced those of the configuration.
std::vector<config::SavedValue> saved_parameters(const nlohmann::ordered_json& header) {
  std::vector<config::SavedValue> saved;
  const auto found = header.find("parameters");
  if (found == header.end() || !found->is_object()) return saved;
  for (const auto& [name, value] : found->items()) {
    if (value.is_number()) saved.push_back({.name = name, .value = value.get<double>()});
  }
  return saved;
}

// The first difference of two schemas, with the names around it.
std::string first_difference(const std::string& theirs, const std::string& ours) {
  const auto [a, b] = std::ranges::mismatch(theirs, ours);
  const auto at = static_cast<std::size_t>(a - theirs.begin());
  const std::size_t from = std::min(at, theirs.rfind(';', at == 0 ? 0 : at - 1) + 1);
  const auto member = [from](const std::string& schema) {
    constexpr std::size_t kShown = 60;
    return from < schema.size() ? schema.substr(from, kShown) : std::string("its end");
  };
  return fmt::format("it has \"{}\" where this program has \"{}\"", member(theirs), member(ours));
}

struct Pass {
  std::uint64_t frames = 0, unknown = 0, lost = 0;
  TimeNs first_ns = 0, last_ns = 0, took_ns = 0;
};

class FileReplay {
 public:
  FileReplay(const fs::path& path, const Print& print, Probe* probe)
      : path_(path), print_(print), probe_(probe) {}

  Replayed run() {
    auto reader = Reader::open(path_);
    if (!reader) {
      say(reader.error());
      const bool damaged = reader.error().find("damaged") != std::string::npos;
      const bool foreign = reader.error().find("has format") != std::string::npos;
      return damaged ? Replayed::damaged : foreign ? Replayed::foreign : Replayed::unreadable;
    }
    introduce(reader->header());
    const bool damaged = !check_bytes(*reader);
    if (const Replayed ours = prepare(reader->header()); ours != Replayed::equal) return ours;
    const Replayed result = execute();
    const bool agrees = result == Replayed::equal || result == Replayed::incomplete;
    return damaged && agrees ? Replayed::damaged : result;
  }

 private:
  void say(const std::string& line) const { print_(line + "\n"); }

  void introduce(const nlohmann::ordered_json& header) const {
    const auto utc_s = static_cast<std::time_t>(header.value("utc_ns", std::int64_t{0}) / kSecond);
    say(fmt::format("{}: {} ({}), lssd {}, build {} ({}), begun {:%F %T} UTC", path_.string(),
                    text(header, "vehicle_id"), text(header, "vehicle"), text(header, "version"),
                    header.contains("build") ? text(header["build"], "id").substr(0, 12) : "?",
                    header.contains("build") ? text(header["build"], "type") : "?",
                    fmt::gmtime(utc_s)));
  }

  // Checks the whole file before any of it is used. False: it is damaged.
  bool check_bytes(Reader& reader) const {
    Item kind;
    std::span<const std::uint8_t> bytes;
    while (reader.next(kind, bytes)) {
    }
    switch (reader.end()) {
      case Reader::End::damaged:
        say(fmt::format("{}; what is whole is replayed", reader.trouble()));
        return false;
      case Reader::End::torn:
        say(fmt::format("torn: {}; what is whole is replayed", reader.trouble()));
        break;
      case Reader::End::open:
        say("not ended: the daemon runs still, was killed, or lost its power; what is whole is "
            "replayed");
        break;
      default: break;
    }
    return true;
  }

  Replayed refuse(const std::string& why) const {
    say("refused: " + why);
    return Replayed::foreign;
  }

  Replayed prepare(const nlohmann::ordered_json& header) {
    const std::string vehicle = text(header, "vehicle");
    const auto records = vehicle_records(vehicle);
    if (!records)
      return refuse(fmt::format("vehicle \"{}\" is not built into this program", vehicle));
    const std::string schema = text(header, "schema"), ours = records->schema();
    if (schema != ours)
      return refuse(fmt::format("its records are laid out otherwise: {}; replay it with lssd {}",
                                first_difference(schema, ours), text(header, "version")));
    same_state_ = text(header, "state_layout") == records->state_layout();
    starts_ = header.value("start", false);
    MakeReplay make;
    auto config = config::parse(
        text(header, "config"), "configuration in the recording", {vehicle},
        [&](const std::string&, config::Section& section) { make = records->replay(section); });
    if (!config)
      return refuse("this program does not take the configuration that was recorded:\n" +
                    config.error());
    config->saved = saved_parameters(header);
    auto replay = make(*config);
    if (!replay)
      return refuse("this program does not take the parameters that it was started with: " +
                    replay.error());
    replay_ = std::move(*replay);
    period_ns_ = config->period_ns;
    return Replayed::equal;
  }

  Replayed execute() {
    auto reader = Reader::open(path_);
    if (!reader) return Replayed::unreadable;
    Item kind;
    std::span<const std::uint8_t> bytes;
    bool known = starts_;
    Pass pass;
    const TimeNs begin_ns = now_ns();
    while (reader->next(kind, bytes)) {
      if (kind == Item::lost) {
        std::uint64_t lost = 0;
        if (bytes.size() == sizeof lost) std::memcpy(&lost, bytes.data(), sizeof lost);
        pass.lost += lost;
        known = false;
      } else if (kind == Item::state) {
        if (known) continue;  // a start further back is the harder test
        if (!same_state_)
          return refuse(
              "it begins in the middle of a run, with the memory of a program of another layout; "
              "replay it with the build that wrote it, or a file with the start of a run");
        if (!replay_->restore(bytes))
          return refuse("what it says of the vehicle's memory is not whole");
        known = true;
      } else if (kind == Item::frame && !known) {
        ++pass.unknown;
      } else if (kind == Item::frame) {
        const Replay::Frame frame = replay_->step(bytes, probe_);
        if (pass.frames++ == 0) pass.first_ns = frame.time_ns;
        pass.last_ns = frame.time_ns;
        if (frame.difference) return differs(frame, pass);
      }
    }
    pass.took_ns = now_ns() - begin_ns;
    return sum_up(pass);
  }

  Replayed differs(const Replay::Frame& frame, const Pass& pass) const {
    say(fmt::format("DIFFERENT in frame {}, {:.3f} s after the first one (T_k {} ns)", frame.frame,
                    static_cast<double>(frame.time_ns - pass.first_ns) * 1e-9, frame.time_ns));
    say("  field     " + frame.difference->field);
    say("  recorded  " + frame.difference->recorded);
    say("  computed  " + frame.difference->computed);
    say(fmt::format("  {} frames before it are equal", pass.frames - 1));
    return Replayed::different;
  }

  Replayed sum_up(const Pass& pass) const {
    if (pass.lost != 0)
      say(fmt::format("{} frames are not in it: the disk or the machine was too slow", pass.lost));
    if (pass.unknown != 0)
      say(fmt::format(
          "{} frames cannot be compared: nothing says what the vehicle remembered before them",
          pass.unknown));
    if (pass.frames == 0) {
      say("no frame was compared");
      return Replayed::incomplete;
    }
    const TimeNs covered_ns = pass.last_ns - pass.first_ns + period_ns_;
    say(fmt::format(
        "equal: {} frames, {:.3f} s, every bit of every output; replayed in {:.3f} s, {:.0f} times "
        "as "
        "fast as they were",
        pass.frames, static_cast<double>(covered_ns) * 1e-9,
        static_cast<double>(pass.took_ns) * 1e-9,
        static_cast<double>(covered_ns) / static_cast<double>(std::max<TimeNs>(pass.took_ns, 1))));
    return pass.unknown == 0 ? Replayed::equal : Replayed::incomplete;
  }

  fs::path path_;
  const Print& print_;
  Probe* probe_;
  std::unique_ptr<Replay> replay_;
  bool starts_ = false, same_state_ = false;
  TimeNs period_ns_ = 0;
};

}  // namespace

Replayed replay_file(const fs::path& path, const Print& print, Probe* probe) {
  return FileReplay(path, print, probe).run();
}

Replayed apart(const std::function<Replayed()>& replay, const Print& print) {
  std::fflush(nullptr);  // or both processes would print it
  const pid_t child = ::fork();
  if (child == 0) {
    const Replayed result = replay();
    std::fflush(nullptr);
    ::_exit(static_cast<int>(result));
  }
  int status = 0;
  pid_t ended = child;
  while (child > 0 && (ended = ::waitpid(child, &status, 0)) < 0 && errno == EINTR) {
  }
  if (ended < 0) {
    print(fmt::format("refused: no process can be begun for it: {}\n", std::strerror(errno)));
    return Replayed::unreadable;
  }
  if (WIFEXITED(status)) return static_cast<Replayed>(WEXITSTATUS(status));
  print(
      fmt::format("refused: executing it ended with signal {}: what it says of the vehicle's "
                  "memory cannot be\n",
                  WTERMSIG(status)));
  return Replayed::damaged;
}

Replayed replay_files(const std::vector<fs::path>& paths, const Print& print) {
  Replayed first = Replayed::equal;
  for (const fs::path& path : paths) {
    const Replayed result = apart([&] { return replay_file(path, print); }, print);
    if (first == Replayed::equal) first = result;
  }
  return first;
}

}  // namespace lss::record
