// The folders of lssd and their free space.

#include <fmt/format.h>

#include "tools/lss-cli/doctor/checks.h"

namespace lss::cli::doctor {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMegabyte = 1'048'576;
constexpr std::uint64_t kRoom = 64 * kMegabyte;
// RouDi's own book-keeping takes 66 MB, the pools of config/roudi.toml 2 MB (2026-11).
constexpr std::uint64_t kSharedMemory = 70 * kMegabyte;

std::string amount(const Space& space) {
  return fmt::format("{} of {} MB free", space.free_bytes / kMegabyte,
                     space.total_bytes / kMegabyte);
}

// `made_by`: the setting of the unit that creates it.
Finding check_folder(const System& system, const std::string& name, const fs::path& folder,
                     const std::string& made_by, const std::string& what) {
  const std::optional<Space> space = system.space(folder);
  if (!space) {
    return {.name = name,
            .result = Result::note,
            .found = fmt::format("{} is not there", folder.string()),
            .meaning = fmt::format("{}; the unit lssd@ makes it ({})", what, made_by),
            .remedy = fmt::format("to run by hand: mkdir -p {}", folder.string())};
  }
  Finding finding{.name = name,
                  .found = fmt::format("{}: {}, {} for this user", folder.string(), amount(*space),
                                       space->writable ? "writable" : "not writable"),
                  .meaning = what};
  if (space->free_bytes < kRoom) {
    finding.result = space->free_bytes == 0 ? Result::problem : Result::warning;
    finding.meaning += ", and there is hardly room";
    finding.remedy = fmt::format("make room: df -h {}", folder.string());
  } else if (!space->writable) {
    finding.result = Result::note;
    finding.meaning += "; it belongs to another user, who may be the unit's";
  }
  return finding;
}

}  // namespace

Finding check_run_dir(const System& system) {
  return check_folder(system, "run_dir", system.run_dir, "RuntimeDirectory=lss",
                      "ports of a simulated vehicle (sim:NAME) are found here");
}

Finding check_state_dir(const System& system) {
  return check_folder(system, "state_dir", system.state_dir, "StateDirectory=lss",
                      "for what is to be kept when lssd ends");
}

Finding check_shm(const System& system, const config::Config* config) {
  const bool wanted = config == nullptr || config->shared_memory;
  const std::optional<Space> space = system.space(system.shm_dir);
  const std::string folder = system.shm_dir.string();
  Finding finding{.name = "shm",
                  .found = space ? fmt::format("{}: {}", folder, amount(*space))
                                 : fmt::format("{} is not there", folder),
                  .meaning = "room for RouDi's shared memory"};
  const std::uint64_t free_bytes = space ? space->free_bytes : 0;
  if (!wanted) finding.meaning = "not needed: dds.shared_memory is false";
  if (!wanted || free_bytes >= kSharedMemory || (space && system.find_roudi())) return finding;
  finding.result = Result::warning;
  finding.meaning =
      fmt::format("RouDi needs {} MB and will not start: telemetry goes by the network",
                  kSharedMemory / kMegabyte);
  finding.remedy =
      fmt::format("mount -o remount,size=256M {}; in a container, give it a larger one", folder);
  return finding;
}

}  // namespace lss::cli::doctor
