// The thread that saves parameters, on a disk that is full.

#include "daemon/parameters/saver.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <semaphore>
#include <vector>

namespace lss {
namespace {

namespace fs = std::filesystem;
using std::chrono::seconds;

class FullDisk final : public StoreFiles {
 public:
  int read(const fs::path&, std::vector<std::uint8_t>&) override { return ENOENT; }
  int write(const fs::path&, std::span<const std::uint8_t>) override {
    if (full) return ENOSPC;
    written.release();
    return 0;
  }
  int rename(const fs::path&, const fs::path&) override { return 0; }
  int sync_folder(const fs::path&) override { return 0; }

  std::atomic<bool> full{true};
  std::counting_semaphore<> written{0};
};

TEST(ParameterSaver, ModulesOutOfServiceThatTheDiskRefusedAreSavedAsSoonAsItTakesThem) {
  FullDisk disk;
  std::counting_semaphore<> done{0};
  ParameterSaver saver(
      {"/state", "zebro", "zebro-1", disk}, {"/state", "zebro", "zebro-1", disk, "isolation"}, {},
      TunableValues{}, [&done] { done.release(); }, kMillisecond);
  saver.start();
  ASSERT_TRUE(saver.ask({.command = {}, .values = {}, .isolation = true, .isolated = 4}));
  ASSERT_TRUE(done.try_acquire_for(seconds(20)));
  SaveResult result;
  ASSERT_TRUE(saver.pop(result));
  EXPECT_EQ(result.error, ENOSPC);
  disk.full = false;
  EXPECT_TRUE(disk.written.try_acquire_for(seconds(20))) << "nobody asked again";
  saver.stop();
  EXPECT_FALSE(saver.pop(result)) << "a retry is no news";
}

TEST(ParameterSaver, TheEndOfTheDaemonIsTheLastTryToSaveModulesOutOfService) {
  FullDisk disk;
  std::counting_semaphore<> done{0};
  ParameterSaver saver(
      {"/state", "zebro", "zebro-1", disk}, {"/state", "zebro", "zebro-1", disk, "isolation"}, {},
      TunableValues{}, [&done] { done.release(); }, 1000 * kSecond);
  saver.start();
  ASSERT_TRUE(saver.ask({.command = {}, .values = {}, .isolation = true, .isolated = 4}));
  ASSERT_TRUE(done.try_acquire_for(seconds(20)));
  disk.full = false;
  saver.stop();
  EXPECT_TRUE(disk.written.try_acquire());
}

}  // namespace
}  // namespace lss
