#include "tools/lss-lc/explorer.h"

#include <algorithm>
#include <bit>
#include <chrono>

namespace lss::lc {
namespace {

// Bits of each part, from the lowest on; modules come last: answering, unheard, silent or isolated
// take two bits each.
constexpr unsigned kStateBits = 2, kModeBits = 5, kGoalBits = 4, kFlagBits = 8, kLinkBits = 3,
                   kStrategyBits = 3;
constexpr unsigned kModuleBits =
    (64 - kStateBits - kModeBits - kGoalBits - kFlagBits - kLinkBits - kStrategyBits) / 2;

constexpr unsigned kNumberBits = 24;
constexpr std::uint32_t kMaxNumber = (1u << kNumberBits) - 1;
constexpr std::uint32_t kNone = ~std::uint32_t{0};

// States in the order in which they were found, with an index by open addressing. A slot has the
// number of its state and eight bits of its hash: most wrong slots are passed without a look at the
// state, which is far away in memory.
class States {
 public:
  States() : slots_(1u << 12, kNone) {}

  std::size_t size() const { return keys_.size(); }
  Key operator[](std::size_t i) const { return keys_[i]; }
  std::uint32_t parent(std::size_t i) const { return parents_[i]; }
  std::uint8_t by(std::size_t i) const { return by_[i]; }
  std::size_t octets() const {
    return keys_.capacity() * sizeof(Key) + parents_.capacity() * sizeof(std::uint32_t) +
           by_.capacity() + slots_.capacity() * sizeof(std::uint32_t);
  }

  // True when it is new.
  bool add(Key key, std::uint32_t parent, std::uint8_t by) {
    std::size_t slot = find(key);
    if (slots_[slot] != kNone) return false;
    if ((keys_.size() + 1) * 4 > slots_.size() * 3) {
      grow();
      slot = find(key);
    }
    slots_[slot] = tag(key) << kNumberBits | static_cast<std::uint32_t>(keys_.size());
    if (keys_.size() == keys_.capacity()) {
      const std::size_t capacity = keys_.size() + std::max<std::size_t>(keys_.size() / 8, 1024);
      keys_.reserve(capacity);
      parents_.reserve(capacity);
      by_.reserve(capacity);
    }
    keys_.push_back(key);
    parents_.push_back(parent);
    by_.push_back(by);
    return true;
  }
  std::uint32_t number(Key key) const {
    const std::uint32_t slot = slots_[find(key)];
    return slot == kNone ? kNone : slot & kMaxNumber;
  }
  void prefetch_slot(Key key) const { __builtin_prefetch(&slots_[home(key)]); }
  void prefetch_key(Key key) const {
    const std::uint32_t slot = slots_[home(key)];
    if (slot != kNone) __builtin_prefetch(&keys_[slot & kMaxNumber]);
  }

 private:
  static std::uint64_t hash(Key key) { return key * 0x9E3779B97F4A7C15u; }
  std::size_t home(Key key) const { return hash(key) >> std::countl_zero(slots_.size() - 1); }
  static std::uint32_t tag(Key key) { return static_cast<std::uint32_t>(hash(key) >> 24) & 0xFF; }
  // Its slot, or the empty one where it belongs.
  std::size_t find(Key key) const {
    const std::size_t mask = slots_.size() - 1;
    const std::uint32_t wanted = tag(key);
    std::size_t slot = home(key);
    for (;; slot = (slot + 1) & mask) {
      const std::uint32_t found = slots_[slot];
      if (found == kNone) return slot;
      if (found >> kNumberBits == wanted && keys_[found & kMaxNumber] == key) return slot;
    }
  }
  void grow() {
    slots_.assign(slots_.size() * 2, kNone);
    for (std::uint32_t i = 0; i < keys_.size(); ++i)
      slots_[find(keys_[i])] = tag(keys_[i]) << kNumberBits | i;
  }

  std::vector<Key> keys_;
  std::vector<std::uint32_t> parents_;
  std::vector<std::uint8_t> by_;
  std::vector<std::uint32_t> slots_;
};

unsigned about_of(const Transition& t) {
  const ControllerState &a = t.before, &b = t.result.next;
  unsigned about = (t.result.actions & ~kOnlyState) != 0 ? unsigned{kActions} : 0U;
  if (a.state != b.state || a.mode != b.mode || a.goal != b.goal || a.strategy != b.strategy)
    about |= kChange;
  if (a.flags != b.flags || a.links != b.links || a.silent != b.silent || a.unheard != b.unheard ||
      a.isolated != b.isolated)
    about |= kLinks;
  return about;
}

class Explorer {
 public:
  Explorer(const Model& model, std::size_t max_states)
      : model_(model), max_states_(std::min<std::size_t>(max_states, kMaxNumber - 100)) {
    result_.row.resize(model.table->common->rows.size() + model.table->rows->rows.size());
    for (const Contract& contract : model.contracts)
      contracts_[static_cast<std::size_t>(contract.event)] = &contract;
  }

  Exploration run() {
    const auto begin = std::chrono::steady_clock::now();
    visit_all();
    if (!result_.violation && result_.complete) check_returns();
    result_.complete = result_.complete && !result_.violation;
    result_.states = states_.size();
    result_.octets = states_.octets();
    result_.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return std::move(result_);
  }

 private:
  void visit_all() {
    states_.add(pack(model_.begin), kNone, 0);
    if (!good(model_.begin, kNone, 0)) return;
    std::size_t level_end = 1;
    for (std::uint32_t i = 0; i < states_.size(); ++i) {
      if (i == level_end) {
        level_end = states_.size();
        ++result_.depth;
      }
      if (!visit(i)) return;
      if (states_.size() > max_states_) return;
    }
    result_.complete = true;
  }

  // Every event in one state; false when something does not hold. Where the next states are in
  // memory is asked for all of them before the first is looked at: that waits once instead of
  // often.
  bool visit(std::uint32_t number) {
    nexts_.clear();
    const ControllerState before = unpack(states_[number]);
    for (std::uint8_t h = 0; h < model_.happenings.size(); ++h) {
      const Happening happening = model_.happenings[h];
      const Result result = step(*model_.table, before, happening.event, happening.subject);
      ++result_.transitions;
      const Transition transition{*model_.table, before, happening, result};
      if (!kept(transition, number, h)) return false;
      if (result.row < 0) continue;
      ++result_.taken;
      ++result_.row[static_cast<std::size_t>(result.row)];
      const unsigned about = about_of(transition);
      for (const StepProperty& property : model_.steps) {
        if ((property.about & about) != 0 && !property.holds(transition))
          return violate(property.name, number, h);
      }
      if (result.next == before) continue;
      if (unpack(pack(result.next)) != result.next)
        return violate("a state can be packed: no module is two things at once", number, h);
      nexts_.push_back({result.next, pack(result.next), h});
      states_.prefetch_slot(nexts_.back().key);
    }
    for (const Next& next : nexts_) states_.prefetch_key(next.key);
    for (const Next& next : nexts_) {
      if (states_.add(next.key, number, next.by) && !good(next.state, number, next.by))
        return false;
    }
    return true;
  }

  bool kept(const Transition& t, std::uint32_t number, std::uint8_t h) {
    const Contract* contract = contracts_[static_cast<std::size_t>(t.happening.event)];
    const bool taken = t.result.row >= 0;
    if (!taken && (t.result.actions != 0 || t.result.verdict.reason == Reason::none ||
                   t.result.next != t.before))
      return violate("a rejection changes nothing and has a reason", number, h);
    if (contract == nullptr) return true;
    if (contract->accepts(t.before, t.happening.subject) != taken)
      return violate(std::string(contract->name) + (taken ? ": taken when it must not be"
                                                          : ": rejected when it must be taken"),
                     number, h);
    if (taken && !contract->leads(t))
      return violate(std::string(contract->name) + ": leads elsewhere", number, h);
    return true;
  }

  bool good(const ControllerState& state, std::uint32_t parent, std::uint8_t h) {
    for (const StateProperty& property : model_.states) {
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

  // Follows the helping world from every state until the target or a state that is known to lead
  // there.
  void check_returns() {
    for (const Return& r : model_.returns) {
      std::vector<bool> returns(states_.size());
      for (std::uint32_t i = 0; i < states_.size(); ++i) {
        std::vector<std::uint32_t> way{i};
        for (ControllerState s = unpack(states_[i]); !returns[way.back()] && !r.reached(s);) {
          const Happening help = r.help(s);
          s = step(*model_.table, s, help.event, help.subject).next;
          way.push_back(states_.number(pack(s)));
          if (way.back() == kNone || way.size() > 1000) {
            result_.violation = Violation{r.name, way_to(i)};
            return;
          }
        }
        for (const std::uint32_t s : way) returns[s] = true;
      }
    }
  }

  const Model& model_;
  std::size_t max_states_;
  std::array<const Contract*, Rows::kEvents> contracts_{};
  struct Next {
    ControllerState state;
    Key key;
    std::uint8_t by;
  };
  States states_;
  std::vector<Next> nexts_;
  Exploration result_;
};

}  // namespace

Key pack(const ControllerState& s) noexcept {
  Key key = 0;
  unsigned at = 0;
  const auto put = [&](std::uint64_t value, unsigned bits) {
    key |= value << at;
    at += bits;
  };
  put(static_cast<std::uint64_t>(s.state), kStateBits);
  put(s.mode, kModeBits);
  put(s.goal, kGoalBits);
  put(s.flags, kFlagBits);
  put(s.links, kLinkBits);
  put(s.strategy, kStrategyBits);
  // A module is at most one of these; what is two breaks the property that says so.
  put(s.silent | s.isolated, kModuleBits);
  put(s.unheard | s.isolated, kModuleBits);
  return key;
}

ControllerState unpack(Key key) noexcept {
  ControllerState s;
  const auto take = [&](unsigned bits) {
    const std::uint64_t value = key & ((std::uint64_t{1} << bits) - 1);
    key >>= bits;
    return value;
  };
  s.state = static_cast<State>(take(kStateBits));
  s.mode = static_cast<std::uint8_t>(take(kModeBits));
  s.goal = static_cast<std::uint8_t>(take(kGoalBits));
  s.flags = static_cast<std::uint8_t>(take(kFlagBits));
  s.links = static_cast<std::uint8_t>(take(kLinkBits));
  s.strategy = static_cast<std::uint8_t>(take(kStrategyBits));
  const std::uint64_t low = take(kModuleBits), high = take(kModuleBits);
  s.isolated = static_cast<std::uint16_t>(low & high);
  s.silent = static_cast<std::uint16_t>(low & ~high);
  s.unheard = static_cast<std::uint16_t>(high & ~low);
  return s;
}

Model model(const Table& table, std::uint16_t modules) {
  Model m{.table = &table,
          .begin = begin(table),
          .happenings = {},
          .states = {},
          .steps = {},
          .contracts = {},
          .returns = {}};
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

Exploration explore(const Model& model, std::size_t max_states) {
  return Explorer(model, max_states).run();
}

}  // namespace lss::lc
