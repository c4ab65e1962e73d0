#pragma once

// The thread that saves parameters: a slow disk delays neither frames nor publishing. Ordinary
// thread; sleeps until asked.

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <thread>

#include "daemon/cycle/supervisor.h"
#include "daemon/cycle/tunables.h"
#include "daemon/parameters/store.h"
#include "daemon/runtime/ring.h"
#include "daemon/runtime/wake_up.h"
#include "drivers/lockstep/lockstep.h"

namespace lss {

struct SaveJob {
  SupervisorState::Active command;  // the one that asks for it
  TunableValues values;
  bool isolation = false;  // instead of the parameters, without a command:
  std::uint16_t isolated = 0;
};

struct SaveResult {
  SupervisorState::Active command;  // kind 0: of an isolation
  int error = 0;
  std::uint64_t number = 0;
  std::uint32_t count = 0;                      // of values that are not the configuration's
  std::array<double, kMaxTunables> saved = {};  // NaN: the configuration's
};

class ParameterSaver {
 public:
  // `configured`: values that need no saving. `done` is called when there is a result. `again`:
  // so often the modules out of service are offered to a disk that refused them.
  ParameterSaver(ParameterStore store, ParameterStore isolation, std::span<const TunableInfo> infos,
                 const TunableValues& configured, std::function<void()> done,
                 TimeNs again = 5 * kSecond);
  ~ParameterSaver() { stop(); }
  ParameterSaver(const ParameterSaver&) = delete;
  ParameterSaver& operator=(const ParameterSaver&) = delete;

  void start();
  void stop();  // when all requested saves are done

  // Frame thread; false: too many at once, or too many results that nobody took.
  bool ask(const SaveJob& job) noexcept;
  // Publish thread; false: none.
  bool pop(SaveResult& result) noexcept;

 private:
  static constexpr std::size_t kCommands = 8;  // whose results were not taken

  void run();
  SaveResult save(const SaveJob& job);
  void save_isolated(const SaveJob& job);
  void save_isolated_again();

  ParameterStore store_, isolation_;
  std::span<const TunableInfo> infos_;
  TunableValues configured_;
  std::function<void()> done_;
  TimeNs again_;
  std::optional<std::uint16_t> refused_;  // modules out of service that are not saved
  TimeNs refused_ns_ = 0;
  Ring<SaveJob, kCommands> jobs_;
  Ring<SaveResult, 2 * kCommands> results_;  // half is reserved for those of commands
  std::atomic<std::size_t> commands_{0};
  WakeUp wake_up_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace lss
