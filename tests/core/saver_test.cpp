// The thread that saves parameters, on a disk that is full.

#include "daemon/parameters/saver.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <future>
#include <utility>
#include <vector>

namespace lss {
namespace {

namespace fs = std::filesystem;

class FullDisk final : public StoreFiles {
 public:
  int read(const fs::path&, std::vector<std::uint8_t>&) override { return ENOENT; }
  int write(const fs::path&, std::span<const std::uint8_t>) override {
    if (full) return ENOSPC;
    if (!std::exchange(written_, true)) written.set_value();
    return 0;
  }
  int rename(const fs::path&, const fs::path&) override { return 0; }
  int sync_folder(const fs::path&) override { return 0; }

  std::atomic<bool> full{true};
  std::promise<void> written;

 private:
  bool written_ = false;
};

class ParameterSaverTest : public testing::Test {
 protected:
  // Module 3 is out of service, and the disk refuses it.
  void refuse(ParameterSaver& saver) {
    saver.start();
    ASSERT_TRUE(saver.ask({.command = {}, .values = {}, .isolation = true, .isolated = 1u << 2}));
    ASSERT_TRUE(comes(done_));
    SaveResult result;
    ASSERT_TRUE(saver.pop(result));
    EXPECT_EQ(result.error, ENOSPC);
    disk_.full = false;
  }
  static bool comes(std::promise<void>& event) {
    return event.get_future().wait_for(std::chrono::seconds(30)) == std::future_status::ready;
  }
  ParameterStore store(const char* what) { return {"/state", "zebro", "zebro-1", disk_, what}; }

  FullDisk disk_;
  std::promise<void> done_;
};

TEST_F(ParameterSaverTest, ModulesOutOfServiceThatTheDiskRefusedAreSavedWhenItTakesThem) {
  ParameterSaver saver(
      store("parameters"), store("isolation"), {}, {}, [this] { done_.set_value(); }, kMillisecond);
  ASSERT_NO_FATAL_FAILURE(refuse(saver));
  EXPECT_TRUE(comes(disk_.written)) << "nobody asked again";
  saver.stop();
  SaveResult result;
  EXPECT_FALSE(saver.pop(result)) << "a retry is no news";
}

TEST_F(ParameterSaverTest, TheEndOfTheDaemonIsTheLastTryToSaveThem) {
  ParameterSaver saver(
      store("parameters"), store("isolation"), {}, {}, [this] { done_.set_value(); },
      1000 * kSecond);
  ASSERT_NO_FATAL_FAILURE(refuse(saver));
  saver.stop();
  EXPECT_TRUE(comes(disk_.written));
}

TEST_F(ParameterSaverTest, ASaveWhoseResultCouldGetLostIsRefused) {
  constexpr int kMost = 8;
  disk_.full = false;
  std::atomic<int> saved = 0;
  ParameterSaver saver(store("parameters"), store("isolation"), {}, {}, [&] {
    if (++saved == kMost) done_.set_value();
  });
  saver.start();
  SaveJob job{.command = {}, .values = {}};
  const auto ask = [&](std::uint64_t sequence) {
    job.command.kind = 10;
    job.command.sequence = sequence;
    return saver.ask(job);
  };
  for (std::uint64_t i = 1; i <= kMost; ++i) ASSERT_TRUE(ask(i));
  ASSERT_TRUE(comes(done_)) << "all are saved";
  EXPECT_FALSE(ask(9)) << "the publisher has taken no result";
  SaveResult result;
  for (std::uint64_t i = 1; i <= kMost; ++i) {
    ASSERT_TRUE(saver.pop(result));
    EXPECT_EQ(result.command.sequence, i);
  }
  EXPECT_TRUE(ask(10));
  saver.stop();
  ASSERT_TRUE(saver.pop(result));
  EXPECT_EQ(result.command.sequence, 10u);
  EXPECT_FALSE(saver.pop(result));
}

}  // namespace
}  // namespace lss
