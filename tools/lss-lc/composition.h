#pragma once

// Visits what supervisor, watch and solver of a vehicle do together when its hardware fails: the
// cycle that ships runs in virtual time over abstract modules, from boot through a mission with an
// operator who does what the documents say, and at each step of it something may go wrong, once or
// twice. Depth first with the state of the cycle (its replay state) stored at each choice; a state
// that is known by its key is not followed again.
//
// A System is one such world, cheap to make:
//   void begin()                       at boot
//   void step()                        one frame, and the properties
//   bool over()                        the mission ended, well or stuck
//   const char* broken()               the violated property; nullptr: none
//   std::uint64_t key()                of the state, quantised
//   std::span<const Choice> choices(bool more, bool every)   what may go wrong or get well now
//   void apply(Choice)
//   void save(Snapshot&), restore(const Snapshot&)
//   std::string text()                 of the state, for people

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <unordered_set>
#include <vector>

namespace lss::lc {

struct Choice {
  std::uint8_t what = 0;    // of the system
  std::uint8_t module = 0;  // from 1 on; 0: none
  bool heals = false;       // ends a failure; else one begins
  bool operator==(const Choice&) const = default;
};

struct Composition {
  std::uint64_t states = 0;  // that differ in their key
  std::uint64_t steps = 0;   // frames of the cycle
  std::uint64_t choices = 0;
  double seconds = 0;
  struct Violation {
    std::string property;
    std::vector<std::string> trace;
  };
  std::optional<Violation> violation;
};

struct Depth {
  unsigned failures = 1;
  bool every = true;               // the second failure at each step; else where something changes
  unsigned threads = 0;            // 0: one for each processor
  std::string only{};              // first failures of this name only; empty: of all
  std::uint16_t modules = 0xFFFF;  // that may fail, bit i: module i+1
};

// Everything that follows when the first failure is of one kind.
template <class System>
class Search {
 public:
  Search(System& system, const Depth& depth, Choice first)
      : system_(system), depth_(depth), first_(first) {}

  Composition run() {
    system_.begin();
    std::uint64_t at = 0;
    for (; !system_.over() && !stopped(); ++at) {
      const auto choices = system_.choices(true, true);
      if (std::ranges::count(choices, first_) != 0) branch(first_, at, depth_.failures - 1);
      advance();
    }
    result_.states = seen_.size();
    return std::move(result_);
  }

 private:
  struct Made {
    std::uint64_t at;
    Choice choice;
  };

  bool may_fail(Choice choice) const {
    return choice.module == 0 || (unsigned{depth_.modules} >> (choice.module - 1) & 1u) != 0;
  }
  bool stopped() const { return result_.violation.has_value(); }

  void branch(Choice choice, std::uint64_t at, unsigned left) {
    typename System::Snapshot here;
    system_.save(here);
    ++result_.choices;
    made_.push_back({at, choice});
    system_.apply(choice);
    follow(at, left);
    made_.pop_back();
    system_.restore(here);
  }

  void follow(std::uint64_t at, unsigned left) {
    for (; !stopped(); ++at) {
      if (!seen_.insert(system_.key() * 4 + left).second) return;
      const auto now = system_.choices(left > 0, depth_.every);
      const std::vector<Choice> choices(now.begin(), now.end());
      for (const Choice choice : choices) {
        if (may_fail(choice)) branch(choice, at, choice.heals ? left : left - 1);
      }
      if (stopped()) return;
      advance();
      if (system_.over()) return;
    }
  }

  void advance() {
    system_.step();
    ++result_.steps;
    if (!stopped() && system_.broken() != nullptr) violate();
  }

  // The way is run again, with a line for each change.
  void violate() {
    Composition::Violation v{system_.broken(), {}};
    const std::vector<Made> made = made_;
    const double end_s = system_.seconds();
    System again(system_.options());
    again.begin();
    std::size_t next = 0;
    std::string last;
    for (std::uint64_t at = 0; again.seconds() < end_s; ++at) {
      for (; next < made.size() && made[next].at == at; ++next) {
        again.apply(made[next].choice);
        v.trace.push_back(again.line(again.name(made[next].choice)));
      }
      again.step();
      if (std::string text = again.text(); text != last) {
        v.trace.push_back(again.line(text));
        last = std::move(text);
      }
    }
    result_.violation = std::move(v);
  }

  System& system_;
  Depth depth_;
  Choice first_;
  std::unordered_set<std::uint64_t> seen_;
  std::vector<Made> made_;
  Composition result_;
};

}  // namespace lss::lc
