// Saved parameters on a disk that fails, loses its power and damages its data.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <sys/stat.h>

#include <cerrno>
#include <filesystem>
#include <map>
#include <string>

#include "daemon/parameters/start.h"
#include "daemon/parameters/store.h"
#include "daemon/record/recording.h"
#include "idl/angles.h"
#include "tests/support/temp_folder.h"

namespace lss {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;
using Values = std::vector<config::SavedValue>;
namespace fs = std::filesystem;

const fs::path kFolder = "/state";

// A file system in memory: the data on the disk, and the data only in the kernel's cache. The power
// can be cut before any of its steps, and in the middle of a write.
class CutDisk final : public StoreFiles {
 public:
  struct Cut {};

  int read(const fs::path& path, Bytes& bytes) override {
    const auto found = files.find(path);
    if (found == files.end()) return ENOENT;
    bytes = found->second;
    return read_error;
  }
  int write(const fs::path& path, std::span<const std::uint8_t> bytes) override {
    if (write_errors_after-- == 0) return ENOSPC;
    if (before_cut == 0) {  // a part of it is on the disk
      const auto part = static_cast<std::ptrdiff_t>(static_cast<double>(bytes.size()) * written);
      files[path] = Bytes(bytes.begin(), bytes.begin() + part);
    }
    step();
    files[path] = Bytes(bytes.begin(), bytes.end());
    return 0;
  }
  int rename(const fs::path& from, const fs::path& to) override {
    step();
    renamed = {from, to};
    before_rename = files;
    files[to] = files.at(from);
    files.erase(from);
    return 0;
  }
  int sync_folder(const fs::path& folder) override {
    EXPECT_EQ(folder, kFolder);
    step();
    renamed = {};
    return 0;
  }
  // A rename without a sync may not have happened.
  void forget_rename() {
    if (!renamed.first.empty()) files = before_rename;
  }

  std::map<fs::path, Bytes> files;
  int before_cut = -1;  // steps; negative: it stays on
  double written = 0;   // share of the write in which it is cut
  int write_errors_after = -1;
  int read_error = 0;

 private:
  void step() {
    if (before_cut-- == 0) throw Cut{};
  }
  std::pair<fs::path, fs::path> renamed;
  std::map<fs::path, Bytes> before_rename;
};

ParameterStore store(CutDisk& disk, const std::string& vehicle = "zebro",
                     const std::string& id = "zebro-1") {
  return {kFolder, vehicle, id, disk};
}

Values values(double x) { return {{"limits.current_A", x}, {"gait.flight_s", x + 2}}; }

bool same(const Values& a, const Values& b) {
  return std::ranges::equal(
      a, b, [](const auto& x, const auto& y) { return x.name == y.name && x.value == y.value; });
}

// As the daemon does: loads, then saves.
int save(CutDisk& disk, const Values& what) {
  ParameterStore s = store(disk);
  s.load();
  std::uint64_t number = 0;
  return s.save(what, 1, number);
}

Bytes with_checksum(Bytes bytes) {
  bytes.resize(bytes.size() - 4);
  const std::uint32_t crc = record::crc32c(bytes);
  for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<std::uint8_t>(crc >> 8 * i));
  return bytes;
}

TEST(ParameterStore, WhatIsSavedIsFoundAgainInBothCopies) {
  CutDisk disk;
  ASSERT_EQ(save(disk, values(1.1)), 0);
  ASSERT_EQ(save(disk, values(1.25)), 0);
  EXPECT_EQ(disk.files.size(), 2U);  // nothing under another name
  ParameterStore s = store(disk);
  EXPECT_EQ(disk.files.at(s.path(0)), disk.files.at(s.path(1)));
  const ParameterStore::Loaded loaded = s.load();
  EXPECT_EQ(loaded.state, SavedState::good);
  EXPECT_TRUE(loaded.troubles.empty());
  ASSERT_TRUE(loaded.taken);
  EXPECT_EQ(loaded.taken->number, 2U);
  EXPECT_TRUE(same(loaded.taken->values, values(1.25)));
}

TEST(ParameterStore, NothingSavedIsNoTrouble) {
  CutDisk disk;
  const ParameterStore::Loaded loaded = store(disk).load();
  EXPECT_EQ(loaded.state, SavedState::none);
  EXPECT_FALSE(loaded.taken);
  EXPECT_TRUE(loaded.troubles.empty());
}

TEST(ParameterStore, EveryBitThatIsFlippedInEitherCopyIsReportedAndTheOtherIsTaken) {
  CutDisk whole;
  ASSERT_EQ(save(whole, values(1.1)), 0);
  for (std::size_t copy = 0; copy < 2; ++copy) {
    const fs::path path = store(whole).path(copy);
    for (std::size_t bit = 0; bit < 8 * whole.files.at(path).size(); ++bit) {
      CutDisk disk = whole;
      disk.files[path][bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
      const ParameterStore::Loaded loaded = store(disk).load();
      ASSERT_EQ(loaded.state, SavedState::one_copy) << path << " bit " << bit;
      ASSERT_THAT(loaded.troubles, ElementsAre(HasSubstr(path.string() + " is damaged")));
      ASSERT_TRUE(loaded.taken && same(loaded.taken->values, values(1.1)));
    }
  }
}

TEST(ParameterStore, EveryLengthThatEitherCopyIsCutToIsReportedAndTheOtherIsTaken) {
  CutDisk whole;
  ASSERT_EQ(save(whole, values(1.1)), 0);
  for (std::size_t copy = 0; copy < 2; ++copy) {
    const fs::path path = store(whole).path(copy);
    for (std::size_t size = 0; size < whole.files.at(path).size(); ++size) {
      CutDisk disk = whole;
      disk.files[path].resize(size);
      const ParameterStore::Loaded loaded = store(disk).load();
      ASSERT_EQ(loaded.state, SavedState::one_copy) << size;
      ASSERT_TRUE(loaded.taken && same(loaded.taken->values, values(1.1)));
    }
  }
}

TEST(ParameterStore, WithoutAGoodCopyNothingIsTakenAndBothAreReported) {
  CutDisk disk;
  ASSERT_EQ(save(disk, values(1.1)), 0);
  for (auto& [path, bytes] : disk.files) bytes[30] ^= 1;
  ParameterStore s = store(disk);
  const ParameterStore::Loaded loaded = s.load();
  EXPECT_EQ(loaded.state, SavedState::lost);
  EXPECT_FALSE(loaded.taken);
  EXPECT_EQ(loaded.troubles.size(), 2U);
  // The next save restores both.
  std::uint64_t number = 0;
  EXPECT_EQ(s.save(values(1.5), 1, number), 0);
  EXPECT_EQ(store(disk).load().state, SavedState::good);
}

TEST(ParameterStore, ACopyThatIsMissingOrCannotBeReadIsReported) {
  CutDisk disk;
  ASSERT_EQ(save(disk, values(1.1)), 0);
  CutDisk one = disk;
  one.files.erase(store(one).path(0));
  const ParameterStore::Loaded loaded = store(one).load();
  EXPECT_EQ(loaded.state, SavedState::one_copy);
  EXPECT_THAT(loaded.troubles, ElementsAre(HasSubstr("is not there")));
  disk.read_error = EIO;
  EXPECT_EQ(store(disk).load().state, SavedState::lost);
}

TEST(ParameterStore, ThoseOfAnotherVehicleOrSchemaAreRefusedByName) {
  CutDisk disk;
  ASSERT_EQ(save(disk, values(1.1)), 0);
  EXPECT_THAT(store(disk, "ardito", "zebro-1").load().troubles[0],
              HasSubstr("is of zebro-1 (zebro), this is zebro-1 (ardito)"));
  const Bytes ours = encode({.number = 1, .utc_ns = 0, .values = {}}, "zebro", "zebro-1");
  EXPECT_THAT(decode(ours, "zebro", "zebro-2").trouble, HasSubstr("this is zebro-2"));
  Bytes newer = ours;
  newer[8] = 2;
  EXPECT_THAT(decode(newer, "zebro", "zebro-1").trouble, HasSubstr("checksum"));
  EXPECT_THAT(decode(with_checksum(newer), "zebro", "zebro-1").trouble,
              HasSubstr("has schema version 2, this program has 1"));
  Bytes longer = ours;
  longer[12] = 1;
  EXPECT_THAT(decode(with_checksum(longer), "zebro", "zebro-1").trouble, HasSubstr("count"));
}

// At every step, with every part of the write completed, the folder synchronised or not.
TEST(ParameterStore, APowerCutAtAnyMomentLeavesTheValuesBeforeOrThoseAfter) {
  constexpr int kSteps = 6;  // write, rename, folder; twice
  bool old_seen = false, new_seen = false;
  for (int at = 0; at < kSteps; ++at) {
    for (const double written : {0.0, 0.3, 0.99, 1.0}) {
      for (const bool rename_lost : {false, true}) {
        CutDisk disk;
        ASSERT_EQ(save(disk, values(1.1)), 0);
        ASSERT_EQ(save(disk, values(1.2)), 0);
        disk.before_cut = at;
        disk.written = written;
        EXPECT_THROW(save(disk, values(1.3)), CutDisk::Cut) << at;
        if (rename_lost) disk.forget_rename();
        const ParameterStore::Loaded loaded = store(disk).load();
        ASSERT_TRUE(loaded.taken) << "step " << at << ", " << written;
        EXPECT_EQ(loaded.state, SavedState::good);
        const bool old = same(loaded.taken->values, values(1.2));
        EXPECT_TRUE(old || same(loaded.taken->values, values(1.3))) << at;
        old_seen = old_seen || old;
        new_seen = new_seen || !old;
        // And it continues from there, with any files around.
        disk.before_cut = -1;
        ASSERT_EQ(save(disk, values(1.4)), 0);
        const ParameterStore::Loaded again = store(disk).load();
        EXPECT_TRUE(again.taken && same(again.taken->values, values(1.4)));
        EXPECT_GT(again.taken->number, loaded.taken->number);
      }
    }
  }
  EXPECT_TRUE(old_seen && new_seen);
  CutDisk disk;
  disk.before_cut = kSteps;
  EXPECT_EQ(save(disk, values(1)), 0);  // there is no other step
}

TEST(ParameterStore, TheVeryFirstSaveThatIsCutLeavesNothingOrAll) {
  for (int at = 0; at < 6; ++at) {
    CutDisk disk;
    disk.before_cut = at;
    disk.written = 0.5;
    EXPECT_THROW(save(disk, values(1.3)), CutDisk::Cut);
    const ParameterStore::Loaded loaded = store(disk).load();
    ASSERT_EQ(loaded.taken.has_value(), at > 1) << at;
    EXPECT_TRUE(at <= 1 || same(loaded.taken->values, values(1.3)));
    EXPECT_NE(loaded.state, SavedState::lost);
  }
}

TEST(ParameterStore, AFullDiskIsReportedAndHarmsNothing) {
  for (const int after : {0, 1}) {
    CutDisk disk;
    ASSERT_EQ(save(disk, values(1.1)), 0);
    disk.write_errors_after = after;
    EXPECT_EQ(save(disk, values(1.2)), ENOSPC);
    const ParameterStore::Loaded loaded = store(disk).load();
    ASSERT_TRUE(loaded.taken);
    EXPECT_TRUE(same(loaded.taken->values, values(after == 0 ? 1.1 : 1.2)));
  }
}

TEST(ParameterStore, AnyBytesAreRefusedOrThoseOfASave) {
  EXPECT_TRUE(rc::check([](const Bytes& bytes, bool checksum) {
    Bytes file = encode({.number = 1, .utc_ns = 0, .values = {}}, "zebro", "zebro-1");
    file.resize(*rc::gen::inRange<std::size_t>(0, file.size() + 1));
    file.insert(file.end(), bytes.begin(), bytes.end());
    if (checksum && file.size() >= 4) file = with_checksum(file);
    const StoredCopy copy = decode(file, "zebro", "zebro-1");
    RC_ASSERT(!copy.absent);
    if (copy.good()) {
      RC_ASSERT(encode(copy.stored, "zebro", "zebro-1").size() == file.size());
    } else {
      RC_ASSERT(copy.stored.values.empty());
    }
  }));
}

TEST(ParameterStore, AnySavedValuesAreReadBack) {
  EXPECT_TRUE(rc::check([](std::vector<double> numbers, std::uint64_t number) {
    StoredParameters stored{.number = number, .utc_ns = 5, .values = {}};
    for (std::size_t i = 0; i < numbers.size(); ++i)
      stored.values.push_back({"name." + std::to_string(i), numbers[i]});
    const StoredCopy copy = decode(encode(stored, "z", "z-1"), "z", "z-1");
    RC_ASSERT(copy.good());
    RC_ASSERT(copy.stored.number == number);
    RC_ASSERT(same(copy.stored.values, stored.values));
  }));
}

TEST(ParameterStore, OnARealDiskItMakesItsFolderAndSaysWhenItCannotWrite) {
  const testing_support::TempFolder folder;
  const fs::path below = folder / "state";
  ParameterStore s(below, "zebro", "zebro-1");
  EXPECT_EQ(s.load().state, SavedState::none);
  std::uint64_t number = 0;
  EXPECT_EQ(s.save(values(1.1), 1, number), 0);
  EXPECT_EQ(number, 1U);
  ParameterStore again(below, "zebro", "zebro-1");
  EXPECT_TRUE(same(again.load().taken->values, values(1.1)));
  EXPECT_EQ(std::distance(fs::directory_iterator(below), fs::directory_iterator()), 2);
  ParameterStore nowhere("/proc/none", "zebro", "zebro-1");
  EXPECT_NE(nowhere.save(values(1.1), 1, number), 0);
}

// ---- loading at the start

constexpr TunableInfo kInfos[] = {
    {"a.speed_m_s", "m/s", 0, 2, Change::always, false, "how fast"},
    {"a.rounds", "", 1, 9, Change::at_rest, true, "how often"},
};

TEST(TakenParameters, ThoseThatAreUnknownOutOfRangeOrBrokenAreReportedByNameAndTheOthersTaken) {
  const TakenParameters taken = vet(kInfos, {{"a.speed_m_s", 1.5},
                                             {"a.sped_m_s", 1.5},
                                             {"a.rounds", 10},
                                             {"a.rounds", 2.5},
                                             {"a.rounds", std::nan("")},
                                             {"a.rounds", 3}});
  ASSERT_EQ(taken.values.size(), 2U);
  EXPECT_EQ(taken.values[0].name, "a.speed_m_s");
  EXPECT_EQ(taken.values[1].value, 3);
  EXPECT_THAT(taken.refused,
              ElementsAre(HasSubstr("a.sped_m_s"), HasSubstr("a.rounds: 10 is out of range 1 to 9"),
                          HasSubstr("2.5"), HasSubstr("nan")));
}

struct P {
  double speed_m_s = 1;
  int rounds = 2;
};
constexpr auto kTunables = std::to_array<Tunable<P>>({
    {kInfos[0], 1, [](P& p) -> TunablePlace { return &p.speed_m_s; }},
    {kInfos[1], 1, [](P& p) -> TunablePlace { return &p.rounds; }},
});
const Tuning<P> kTuning{
    kTunables, kInfos, [](P&) {},
    [](const P& p) -> const char* { return p.speed_m_s * p.rounds > 4 ? "too much" : nullptr; }};

TEST(TakenParameters, ThoseThatDoNotGoTogetherAreAllLeft) {
  P p;
  EXPECT_EQ(take_saved(kTuning, {{"a.speed_m_s", 1.5}}, p).values.size(), 1U);
  EXPECT_EQ(p.speed_m_s, 1.5);
  const TakenParameters taken = take_saved(kTuning, {{"a.speed_m_s", 2}, {"a.rounds", 3}}, p);
  EXPECT_TRUE(taken.values.empty());
  EXPECT_THAT(taken.refused, ElementsAre(HasSubstr("too much")));
  EXPECT_EQ(p.speed_m_s, 1.5);
  EXPECT_EQ(p.rounds, 2);
}

TEST(Tunables, AValueIsReportedAsAPersonWouldWriteIt) {
  const Tunable<P> degrees{kInfos[0], kDegree, [](P& p) -> TunablePlace { return &p.speed_m_s; }};
  P p;
  for (const double value : {0.1, 0.7, 12.3, 120.0, -33.3, 0.0, 1e-6, 123456.789}) {
    set_tunable(degrees, p, value);
    EXPECT_EQ(get_tunable(degrees, p), value);
  }
}

TEST(ParameterStore, APipeInThePlaceOfACopyKeepsNobodyWaiting) {
  const testing_support::TempFolder folder;
  ParameterStore store(folder, "zebro", "z-1");
  ASSERT_EQ(::mkfifo(store.path(0).c_str(), 0600), 0);
  const auto loaded = store.load();
  EXPECT_EQ(loaded.state, SavedState::lost);
  EXPECT_THAT(loaded.troubles, ElementsAre(HasSubstr("is damaged: 0 bytes")));
}

}  // namespace
}  // namespace lss
