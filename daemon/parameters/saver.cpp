#include "daemon/parameters/saver.h"

#include <pthread.h>
#include <spdlog/spdlog.h>

#include <system_error>
#include <utility>

#include "daemon/parameters/start.h"
#include "daemon/runtime/clock.h"

namespace lss {

namespace {

void report(int error, const char* what, const ParameterStore& store, const char* advice) {
  if (error == 0) return;
  spdlog::error("{} cannot be saved in {}: {}; {}", what, store.path(0).parent_path().string(),
                std::generic_category().message(error), advice);
}

}  // namespace

ParameterSaver::ParameterSaver(ParameterStore store, ParameterStore isolation,
                               std::span<const TunableInfo> infos, const TunableValues& configured,
                               std::function<void()> done, TimeNs again)
    : store_(std::move(store)),
      isolation_(std::move(isolation)),
      infos_(infos),
      configured_(configured),
      done_(std::move(done)),
      again_(again) {}

void ParameterSaver::start() {
  thread_ = std::thread([this] { run(); });
}

void ParameterSaver::stop() {
  if (!thread_.joinable()) return;
  stop_ = true;
  wake_up_.wake();
  thread_.join();
}

bool ParameterSaver::ask(const SaveJob& job) noexcept {
  if (jobs_.room() == 0 || (!job.isolation && commands_ == kCommands)) return false;
  if (!job.isolation) ++commands_;
  jobs_.push(job);
  wake_up_.wake();
  return true;
}

bool ParameterSaver::pop(SaveResult& result) noexcept {
  if (!results_.pop(result)) return false;
  if (result.command.kind != 0) --commands_;
  return true;
}

void ParameterSaver::run() {
  ::pthread_setname_np(::pthread_self(), "save");
  const lockstep::Part part("save");
  for (bool last = false; !last;) {
    wake_up_.wait(refused_ ? refused_ns_ + again_ : lockstep::kNever);
    last = stop_;
    for (SaveJob job; jobs_.pop(job);) {
      if (job.isolation) {
        save_isolated(job);
      } else {
        results_.push(save(job));
      }
      done_();
    }
    if (refused_ && (last || now_ns() >= refused_ns_ + again_)) save_isolated_again();
  }
}

void ParameterSaver::save_isolated(const SaveJob& job) {
  SaveResult result;
  result.error = save_isolation(isolation_, job.isolated, utc_ns());
  report(
      result.error, "modules out of service", isolation_,
      "until they are, a restart puts these modules into service again: free or repair the disk");
  refused_.reset();
  if (result.error != 0) refused_ = job.isolated;
  refused_ns_ = now_ns();
  if (results_.room() > kCommands) results_.push(result);
}

// Reported again only when they are saved.
void ParameterSaver::save_isolated_again() {
  refused_ns_ = now_ns();
  if (save_isolation(isolation_, *refused_, utc_ns()) != 0) return;
  refused_.reset();
  spdlog::info("modules out of service are saved now");
}

SaveResult ParameterSaver::save(const SaveJob& job) {
  SaveResult result{.command = job.command};
  result.saved.fill(kRequired);
  std::vector<config::SavedValue> values;
  for (std::size_t i = 0; i < infos_.size(); ++i) {
    if (same_value(job.values.value[i], configured_.value[i])) continue;
    values.push_back({.name = infos_[i].name, .value = job.values.value[i]});
    result.saved[i] = job.values.value[i];
  }
  result.count = static_cast<std::uint32_t>(values.size());
  result.error = store_.save(values, utc_ns(), result.number);
  report(result.error, "parameters", store_,
         "free or repair the disk, make the folder writable, or name another parameters.folder");
  return result;
}

}  // namespace lss
