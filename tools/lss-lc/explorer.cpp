#include "tools/lss-lc/explorer.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <stdexcept>
#include <type_traits>

#include "tools/lss-lc/states.h"
#include "tools/lss-lc/team.h"

namespace lss::lc {
namespace {

constexpr std::uint32_t kNone = States::kNone;

// States are visited in pieces. Several pieces run at the same time, while the index is only read.
// The new states of the pieces are added afterwards, in piece order: the same order as with one
// thread. States. The successors stay below 128 KiB: larger blocks are mapped by malloc at a page
// boundary, which cost a third of the time (2026-11, 128 states).
constexpr std::uint32_t kPiece = 64;
constexpr std::uint32_t kPiecesAtATime = 64;  // with several threads
constexpr std::uint32_t kShare = 8192;        // states whose way back is searched at once

// The successor of a step.
struct Next {
  Key key;
  std::uint32_t parent;
  std::uint8_t by;
};

// A step that breaks a property.
struct Break {
  std::string property;
  std::uint32_t number;  // of the state before the step
  std::uint8_t by;
};

struct alignas(64) Piece {            // each in its own cache line: threads write to them
  std::uint32_t first = 0, last = 0;  // states, without the last one
  std::vector<Next> nexts;            // in the order of steps; those that may be new
  std::uint64_t taken = 0;
  std::vector<std::uint64_t> row;
  std::optional<Break> violated;  // by the last step examined
};

// The data of one thread: the successors of its piece, and recent keys, which need no second
// lookup: each is old, or was found in an earlier step.
class Scratch {
 public:
  Scratch(Key known, std::size_t steps) : nexts_(steps), met_(std::size_t{1} << kBits, known) {}
  void clear() { count_ = 0; }
  // Branch-free: half of all keys are known, which is unpredictable.
  void add(const Next& next) {
    Key& place = met_[next.key * 0x9E3779B97F4A7C15u >> (64 - kBits)];
    nexts_[count_] = next;
    count_ += place != next.key ? 1U : 0U;
    place = next.key;
  }
  std::span<const Next> nexts() const { return {nexts_.data(), count_}; }
  std::size_t bytes() const {
    return nexts_.capacity() * sizeof(Next) + met_.capacity() * sizeof(Key);
  }

 private:
  static constexpr unsigned kBits = 13;
  std::vector<Next> nexts_;
  std::size_t count_ = 0;
  std::vector<Key> met_;
};

// The changes of a step, from the packed states before and after: the first parts of a key are
// state, mode, goal and strategy.
unsigned about_of(Key before, Key after, ActionSet actions) {
  const Key changed = before ^ after;
  return ((changed << (64 - KeyBits::kFirst)) != 0 ? unsigned{kChange} : 0U) |
         ((changed >> KeyBits::kFirst) != 0 ? unsigned{kLinks} : 0U) |
         ((actions & ~kOnlyState) != 0 ? unsigned{kActions} : 0U);
}

// a == b, in two comparisons instead of nine.
bool same(const ControllerState& a, const ControllerState& b) {
  static_assert(std::has_unique_object_representations_v<ControllerState>);
  return std::memcmp(&a, &b, sizeof a) == 0;
}

// An event, and what the properties say of it.
struct Expected {
  Happening happening;
  const Contract* contract;  // nullptr: none
  std::vector<const Duty*> duties;
};

class Explorer {
 public:
  Explorer(const Model& model, const Effort& effort)
      : model_(model),
        max_states_(std::min<std::size_t>(effort.max_states, States::kMaxNumber - kPiece * 256)),
        team_(effort.threads != 0 ? effort.threads
                                  : std::max(1U, std::thread::hardware_concurrency())),
        scratch_(team_.members(), Scratch(pack(model.begin), kPiece * model.happenings.size())),
        pieces_(team_.members() == 1 ? 1 : kPiecesAtATime) {
    result_.row.resize(model.table->common->rows.size() + model.table->rows->rows.size());
    for (const Happening happening : model.happenings) {
      const auto contract = std::find_if(
          model.contracts.begin(), model.contracts.end(),
          [&](const Contract& candidate) { return candidate.event == happening.event; });
      events_.push_back({happening, contract == model.contracts.end() ? nullptr : &*contract, {}});
      for (const Duty& duty : model.duties) {
        if (std::ranges::count(duty.events, happening.event) != 0)
          events_.back().duties.push_back(&duty);
      }
    }
  }

  Exploration run() {
    const auto begin = std::chrono::steady_clock::now();
    visit_all();
    if (!result_.violation && result_.complete) check_returns();
    result_.complete = result_.complete && !result_.violation;
    result_.states = states_.size();
    result_.bytes = bytes();
    result_.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return std::move(result_);
  }

 private:
  void visit_all() {
    states_.add(pack(model_.begin), kNone, 0);
    if (!good(model_.begin, kNone, 0)) return;
    for (std::uint32_t first = 0; first < states_.size(); ++result_.depth) {
      const std::uint32_t level_end = states_.size();
      while (first < level_end) {
        const std::size_t pieces = divide(first, level_end);
        team_.run(pieces, [this](std::size_t i, unsigned member) {
          visit(pieces_[i], scratch_[member]);
          take_new(scratch_[member].nexts(), pieces_[i]);
        });
        for (std::size_t i = 0; i < pieces; ++i) {
          if (!add(pieces_[i]) || states_.size() > max_states_) return;
        }
        first = pieces_[pieces - 1].last;
      }
    }
    --result_.depth;  // the last one found nothing new
    result_.complete = true;
  }

  std::size_t divide(std::uint32_t first, std::uint32_t end) {
    std::size_t count = 0;
    for (; count < pieces_.size() && first < end; ++count) {
      Piece& piece = pieces_[count];
      piece.first = first;
      piece.last = first = std::min(end, first + kPiece);
    }
    return count;
  }

  // Every event in every state of the piece, or until a violation.
  void visit(Piece& piece, Scratch& scratch) const {
    scratch.clear();
    piece.row.assign(result_.row.size(), 0);
    piece.taken = 0;
    for (std::uint32_t number = piece.first; number < piece.last; ++number) {
      const Key key = states_[number];
      const ControllerState before = unpack(key);
      for (std::uint8_t by = 0; by < events_.size(); ++by) {
        const auto& [happening, contract, duties] = events_[by];
        const Result result = step(*model_.table, before, happening.event, happening.subject);
        const Transition transition{*model_.table, before, happening, result};
        const bool taken = result.row >= 0;
        const Key next = taken ? pack(result.next) : key;
        const unsigned about = about_of(key, next, result.actions);
        const bool kept =
            std::ranges::all_of(duties, [&](const Duty* d) { return done(*d, transition); }) &&
            (contract == nullptr || contract->accepts(before, happening.subject) == taken) &&
            (taken ? packs(result.next) && (contract == nullptr || contract->leads(transition)) &&
                         model_.steps.all[about](transition)
                   : refused(transition));
        if (!kept) {
          piece.violated = {broken(transition, events_[by], about), number, by};
          return;
        }
        if (!taken) continue;
        ++piece.taken;
        ++piece.row[static_cast<std::size_t>(result.row)];
        if (next != key) scratch.add({stand_in(result.next, next), number, by});
      }
    }
  }

  Key stand_in(const ControllerState& state, Key key) const {
    return model_.stands_for == nullptr ? key : pack(model_.stands_for(state));
  }

  static bool refused(const Transition& t) {
    return t.result.actions == 0 && t.result.verdict.reason != Reason::none &&
           same(t.result.next, t.before);
  }
  static bool done(const Duty& duty, const Transition& t) {
    return !duty.due(t.before, t.happening) || (t.result.row >= 0 && duty.met(t));
  }
  // The properties that a step violates.
  std::string broken(const Transition& t, const Expected& expected, unsigned about) const {
    const bool taken = t.result.row >= 0;
    const Contract* contract = expected.contract;
    for (const Duty* duty : expected.duties) {
      if (!done(*duty, t)) return duty->name;
    }
    if (!taken && !refused(t)) return "a rejection changes nothing and has a reason";
    if (contract != nullptr && contract->accepts(t.before, t.happening.subject) != taken)
      return std::string(contract->name) +
             (taken ? ": taken when it must not be" : ": rejected when it must be taken");
    if (!packs(t.result.next)) return "a state can be packed: no module is two things at once";
    if (contract != nullptr && !contract->leads(t))
      return std::string(contract->name) + ": leads elsewhere";
    for (const StepProperty& property : model_.steps.each) {
      if ((property.about & about) != 0 && !property.holds(t)) return property.name;
    }
    throw std::logic_error("a property that does not hold holds when asked alone");
  }

  // Removes the states that are in the index. The memory of a lookup is prefetched some lookups
  // ahead.
  void take_new(std::span<const Next> found, Piece& piece) const {
    constexpr std::size_t kSlots = 24, kKeys = 12;  // ahead
    piece.nexts.clear();
    for (std::size_t i = 0; i < std::min(kSlots, found.size()); ++i)
      states_.prefetch_slot(found[i].key);
    for (std::size_t i = 0; i < found.size(); ++i) {
      if (i + kSlots < found.size()) states_.prefetch_slot(found[i + kSlots].key);
      if (i + kKeys < found.size()) states_.prefetch_key(found[i + kKeys].key);
      if (states_.number(found[i].key) == kNone) piece.nexts.push_back(found[i]);
    }
  }

  // Adds the new states of the piece; false at a violation.
  bool add(Piece& piece) {
    constexpr std::size_t kSlots = 8;
    const std::size_t events = events_.size();
    result_.transitions +=
        piece.violated ? (piece.violated->number - piece.first) * events + piece.violated->by + 1
                       : (piece.last - piece.first) * events;
    result_.taken += piece.taken;
    for (std::size_t i = 0; i < piece.row.size(); ++i) result_.row[i] += piece.row[i];
    for (std::size_t i = 0; i < piece.nexts.size(); ++i) {
      if (i + kSlots < piece.nexts.size()) states_.prefetch_slot(piece.nexts[i + kSlots].key);
      const Next& next = piece.nexts[i];
      if (piece.violated && next.parent == piece.violated->number) break;
      if (states_.add(next.key, next.parent, next.by) &&
          !good(unpack(next.key), next.parent, next.by))
        return false;
    }
    return !piece.violated ||
           violate(piece.violated->property, piece.violated->number, piece.violated->by);
  }

  bool good(const ControllerState& state, std::uint32_t parent, std::uint8_t h) {
    if (model_.states.all(*model_.table, state)) return true;
    for (const StateProperty& property : model_.states.each) {
      if (!property.holds(*model_.table, state)) return violate(property.name, parent, h);
    }
    return true;
  }

  bool violate(std::string property, std::uint32_t number, std::uint8_t h) {
    Violation v{std::move(property), {}};
    if (number != kNone) v.trace = way_to(number);
    if (number != kNone) v.trace.push_back(model_.happenings[h]);
    result_.violation = std::move(v);
    return false;
  }
  std::vector<Happening> way_to(std::uint32_t number) const {
    std::vector<Happening> way;
    for (; states_.parent(number) != kNone; number = states_.parent(number))
      way.push_back(model_.happenings[states_.by(number)]);
    std::reverse(way.begin(), way.end());
    return way;
  }

  void check_returns() {
    const std::uint32_t size = states_.size();
    for (const Return& r : model_.returns) {
      // Of each thread: states known to lead there.
      std::vector<std::vector<bool>> returns(team_.members(), std::vector<bool>(size));
      std::vector<std::uint32_t> lost((size - 1) / kShare + 1);
      team_.run(lost.size(), [&](std::size_t i, unsigned member) {
        const auto first = static_cast<std::uint32_t>(i) * kShare;
        lost[i] = first_lost(r, first, std::min(size, first + kShare), returns[member]);
      });
      for (const std::uint32_t number : lost) {
        if (number == kNone) continue;
        result_.violation = Violation{r.name, way_to(number)};
        return;
      }
    }
  }
  // Follows the cooperative environment from each of these states to the target, or to a state
  // known to lead there. Returns the first state from which it runs in a circle.
  std::uint32_t first_lost(const Return& r, std::uint32_t first, std::uint32_t last,
                           std::vector<bool>& returns) const {
    std::vector<std::uint32_t> way;
    for (std::uint32_t i = first; i < last; ++i) {
      way.assign(1, i);
      for (ControllerState s = unpack(states_[i]); !returns[way.back()] && !r.reached(s);) {
        const Happening help = r.help(s);
        s = lc::stand_in(model_, step(*model_.table, s, help.event, help.subject).next);
        way.push_back(states_.number(pack(s)));
        if (way.back() == kNone || way.size() > states_.size()) return i;
      }
      for (const std::uint32_t number : way) returns[number] = true;
    }
    return kNone;
  }

  std::size_t bytes() const {
    std::size_t sum = states_.bytes();
    for (const Scratch& scratch : scratch_) sum += scratch.bytes();
    for (const Piece& piece : pieces_)
      sum += piece.nexts.capacity() * sizeof(Next) + piece.row.capacity() * sizeof(piece.row[0]);
    return sum;
  }

  const Model& model_;
  std::size_t max_states_;
  std::vector<Expected> events_;
  States states_;
  Team team_;
  std::vector<Scratch> scratch_;  // of each member
  std::vector<Piece> pieces_;
  Exploration result_;
};

}  // namespace

Model model(const Table& table, std::uint16_t modules) {
  Model m{.table = &table,
          .begin = begin(table),
          .happenings = {},
          .states = {},
          .steps = {},
          .duties = {},
          .contracts = {},
          .returns = {},
          .stands_for = nullptr};
  m.begin.unheard &= modules;
  for (const std::span<const EventInfo> events : {kCommonEvents, table.events}) {
    for (const EventInfo& e : events) {
      if (e.subjects == 0) m.happenings.push_back({e.event, 0});
      const unsigned last = e.subjects == kEachModule ? table.modules : e.subjects;
      for (unsigned subject = 1; subject <= last; ++subject) {
        if ((unsigned{modules} >> (subject - 1) & 1u) != 0)
          m.happenings.push_back({e.event, static_cast<std::uint8_t>(subject)});
      }
    }
  }
  return m;
}

Exploration explore(const Model& model, const Effort& effort) {
  return Explorer(model, effort).run();
}

}  // namespace lss::lc
