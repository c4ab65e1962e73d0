// Every fault of lss-sim on a walking Lunar Zebro, alone and two at a time: the reaction, its time,
// what is on the wire, and the way back. docs/faults-zebro.md is made and checked here.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>
#include <string_view>

#include "tests/support/everything.h"
#include "tests/zebro/chain/fault_cases.h"
#include "tests/zebro/chain/fault_document.h"

namespace lss::zebro {
namespace {

constexpr unsigned kMoments = 10, kPairMoments = 2;
constexpr std::size_t kSample = 5;  // of the rows of pairs
constexpr const char* kReactions[] = {"walks on", "walks on, warns", "stops"};
constexpr const char* kLasting[] = {"", "Idle", "Idle, the leg isolated", "FatalError"};

std::string_view kind(const FaultCase& fault) {
  const std::string_view text = fault.fault;
  return text.substr(0, text.find(':'));
}

// LSS_SEED=1, 2, ...: other moments and legs than usual, for a search.
unsigned other_moments() {
  const char* seed = std::getenv("LSS_SEED");
  return seed == nullptr ? 0 : static_cast<unsigned>(std::strtoul(seed, nullptr, 10));
}

// The second one takes the place of the first.
bool replaces(const FaultCase& first, const FaultCase& second, bool one_leg) {
  return kind(first) == kind(second) && (one_leg || !first.of_module());
}

std::string name(std::size_t number) {
  std::string name = fault_cases()[number].fault;
  std::erase(name, '#');
  std::ranges::replace_if(
      name, [](char c) { return std::isalnum(c) == 0; }, '_');
  return name;
}

class FaultsTest : public testing::TestWithParam<std::size_t> {
 protected:
  unsigned draw_leg() { return std::uniform_int_distribution(1u, 6u)(random_); }
  double draw(double to) { return std::uniform_real_distribution(0.0, to)(random_); }

  Observed broken(std::span<const Injection> injections) {
    const auto seed = static_cast<unsigned>(random_());
    Observed observed = break_walk(seed, injections);
    for (const std::string& wrong : observed.wrong) {
      std::string what;
      for (const Injection& i : injections)
        what += fmt::format("{} after {:.4f} s, ", i.fault->text(i.module), i.at_s);
      ADD_FAILURE() << what << "seed " << seed << ": " << wrong;
    }
    return observed;
  }

  void break_pair(const FaultCase& second, bool one_leg) {
    if (replaces(first_, second, one_leg)) return;
    for (unsigned k = 0; k < kPairMoments; ++k) {
      const unsigned leg = draw_leg();
      const unsigned other = one_leg ? leg : (leg + draw_leg() % 5) % 6 + 1;
      const bool near = k == 0 && first_.reaction == Reaction::stops;
      const Injection both[] = {{&first_, leg, 0},
                                {&second, other, draw(near ? first_.within_s : 2)}};
      broken(both);
    }
  }

  const FaultCase& first_ = fault_cases()[GetParam()];
  std::mt19937 random_{static_cast<unsigned>(GetParam()) + 1000 * other_moments()};
};

class FaultAlone : public FaultsTest {};
class FaultPairs : public FaultsTest {};
class FaultsOnOneLeg : public FaultsTest {};

TEST_P(FaultAlone, IsAnsweredInItsTime) {
  double least_s = INFINITY, most_s = 0;
  for (unsigned k = 0; k < kMoments; ++k) {
    const Injection injection{&first_, draw_leg(), 0};
    const Observed observed = broken({&injection, 1});
    const auto said_s = observed.stopped_s ? observed.stopped_s : observed.warned_s;
    least_s = std::min(least_s, said_s.value_or(INFINITY));
    most_s = std::max(most_s, said_s.value_or(0));
  }
  const Injection injection{&first_, 3, 0};
  const Lasting lasting = solve_while_it_lasts(static_cast<unsigned>(random_()), injection);
  EXPECT_EQ(lasting, first_.lasting) << kLasting[static_cast<int>(lasting)];

  const bool says = first_.id != FaultId::none;
  const std::string row =
      fmt::format("| {} | `{}` | {} | {} | {} | {} | {} | {} |", GetParam() + 1, first_.text(3),
                  kReactions[static_cast<int>(first_.reaction)],
                  says ? fmt::format("`{}`", info(first_.id)->name) : "",
                  says ? fmt::format("{:.0f}", first_.within_s * 1e3) : "", first_.because,
                  says ? fmt::format("{:.0f} to {:.0f}", least_s * 1e3, most_s * 1e3) : "",
                  kLasting[static_cast<int>(first_.lasting)]);
  EXPECT_EQ(check_row(GetParam(), row), "");
}

TEST_P(FaultPairs, AreAnsweredByTheEarlierTimeOfBoth) {
  LSS_SKIP_OUTSIDE_SAMPLE(GetParam(), kSample);
  for (const FaultCase& second : paired_cases()) break_pair(second, false);
}

TEST_P(FaultsOnOneLeg, AreAnsweredByTheEarlierTimeOfBoth) {
  LSS_SKIP_OUTSIDE_SAMPLE(GetParam(), kSample);
  for (const FaultCase& second : paired_cases()) {
    if (second.of_module()) break_pair(second, true);
  }
}

const std::size_t kAll = fault_cases().size();
const std::size_t kOfModules =
    static_cast<std::size_t>(std::ranges::count_if(paired_cases(), &FaultCase::of_module));
const std::size_t kInPairs = paired_cases().size();
const auto kName = [](const auto& number) { return name(number.param); };
INSTANTIATE_TEST_SUITE_P(Zebro, FaultAlone, testing::Range(std::size_t{0}, kAll), kName);
INSTANTIATE_TEST_SUITE_P(Zebro, FaultPairs, testing::Range(std::size_t{0}, kInPairs), kName);
INSTANTIATE_TEST_SUITE_P(Zebro, FaultsOnOneLeg, testing::Range(std::size_t{0}, kOfModules), kName);

TEST(FaultDocument, HasTheseRowsAndNoOthers) { EXPECT_EQ(check_frame(kAll), ""); }

class Writer : public testing::Environment {
 public:
  void TearDown() override {
    if (writing_faults()) write_faults();
  }
};
const auto* const kWriter = testing::AddGlobalTestEnvironment(new Writer);

}  // namespace
}  // namespace lss::zebro
