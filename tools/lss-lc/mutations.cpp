#include "tools/lss-lc/mutations.h"

#include <fmt/format.h>

#include <chrono>
#include <set>
#include <utility>

namespace lss::lc {
namespace {

using AllRows = std::vector<Row>;

// A table with one row changed.
class Mutant {
 public:
  Mutant(const Table& table, std::size_t row, const Row& changed)
      : common_(with(table.common->rows, row, changed)),
        own_(with(table.rows->rows, row - table.common->rows.size(), changed)),
        common_rows_(common_),
        own_rows_(own_),
        table_(table) {
    table_.common = &common_rows_;
    table_.rows = &own_rows_;
  }
  const Table& table() const { return table_; }

 private:
  static AllRows with(std::span<const Row> rows, std::size_t row, const Row& changed) {
    AllRows all(rows.begin(), rows.end());
    if (row < all.size()) all[row] = changed;
    return all;
  }

  AllRows common_, own_;
  Rows common_rows_, own_rows_;
  Table table_;
};

bool commanded(const Model& model, Event event) {
  for (const std::span<const EventInfo> events : {kCommonEvents, model.table->events}) {
    for (const EventInfo& e : events) {
      if (e.event == event) return e.command;
    }
  }
  return false;
}

// In every reachable state every event has the same effect. Actions that only change the state are
// done with it, and the reason of a refusal is for who commanded: a report has none.
bool behaves_the_same(const Model& a, const Model& b) {
  std::set<Key> seen{pack(a.begin)};
  std::vector<ControllerState> left{a.begin};
  while (!left.empty()) {
    const ControllerState state = left.back();
    left.pop_back();
    for (const Happening h : a.happenings) {
      const Result of_a = step(*a.table, state, h.event, h.subject),
                   of_b = step(*b.table, state, h.event, h.subject);
      if (of_a.next != of_b.next || ((of_a.actions ^ of_b.actions) & ~kOnlyState) != 0 ||
          (of_a.row < 0) != (of_b.row < 0) ||
          (commanded(a, h.event) && of_a.verdict.reason != of_b.verdict.reason))
        return false;
      if (seen.insert(pack(of_a.next)).second) left.push_back(of_a.next);
    }
  }
  return true;
}

class Measure {
 public:
  explicit Measure(const Verified& vehicle)
      : vehicle_(vehicle),
        table_(*vehicle.table),
        modes_(static_cast<std::uint8_t>(vehicle.mode_names.size())),
        goals_(static_cast<std::uint8_t>(vehicle.goal_names.size())) {}

  Mutations run() {
    const auto begin = std::chrono::steady_clock::now();
    const std::size_t common = table_.common->rows.size();
    for (row_ = 0; row_ < common + table_.rows->rows.size(); ++row_) {
      original_ = row_ < common ? table_.common->rows[row_] : table_.rows->rows[row_ - common];
      drop();
      redirect();
      loosen();
      idle();
      widen();
      busy();
    }
    result_.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return std::move(result_);
  }

 private:
  Model model_of(const Table& table) const { return vehicle_.model(table, vehicle_.few); }

  void attempt(Change change, const Row& changed, const std::string& what) {
    const Mutant mutant(table_, row_, changed);
    Mutations::Count& count = result_.of[static_cast<std::size_t>(change)];
    ++count.all;
    const Model model = model_of(mutant.table());
    Model demands = model;
    demands.contracts = {};
    const auto text = [&] { return fmt::format("row {} ({}): {}", row_, name(), what); };
    if (explore(demands, {.threads = 1}).violation) {
      ++count.demanded;
      ++count.caught;
    } else if (behaves_the_same(model_of(table_), model)) {
      ++count.equivalent;
    } else if (explore(model, {.threads = 1}).violation) {
      ++count.caught;
      result_.undemanded.push_back(text());
    } else {
      result_.survivors.push_back(text());
    }
  }

  std::string name() const {
    const std::string event = text(vehicle_, Happening{original_.event, 0});
    if ((original_.from & in(State::operational)) == 0 || original_.modes == kAnyMode) return event;
    std::string all = event + " in";
    for (unsigned mode = 1; mode < modes_; ++mode) {
      if ((original_.modes >> mode & 1u) != 0) all += fmt::format(" {}", vehicle_.mode_names[mode]);
    }
    return original_.goal == kKeep
               ? all
               : all + fmt::format(", goal {}", vehicle_.goal_names[original_.goal]);
  }

  // Every transition of the row: each state, each mode.
  void drop() {
    for (unsigned s = 0; s < 4; ++s) {
      const auto state = static_cast<State>(s);
      if ((original_.from & in(state)) == 0) continue;
      if (state == State::operational && original_.modes != kAnyMode) continue;
      Row row = original_;
      row.from = static_cast<StateSet>(row.from & ~in(state));
      attempt(Change::dropped, row, fmt::format("not from {}", kStateNames[s]));
    }
    if ((original_.from & in(State::operational)) == 0) return;
    for (unsigned mode = 1; mode < modes_; ++mode) {
      if ((original_.modes >> mode & 1u) == 0) continue;
      Row row = original_;
      row.modes &= ~(1u << mode);
      attempt(Change::dropped, row, fmt::format("not from {}", vehicle_.mode_names[mode]));
    }
  }

  void redirect() {
    for (unsigned s = 0; s < 4; ++s) {
      const auto state = static_cast<State>(s);
      if (state == State::operational) continue;
      if (original_.to_mode != kKeep && original_.to == state) continue;
      if (original_.to_mode == kKeep && original_.from == in(state)) continue;  // the same
      Row row = original_;
      row.to = state;
      row.to_mode = row.to_goal = 0;
      attempt(Change::redirected, row, fmt::format("to {}", kStateNames[s]));
    }
    for (std::uint8_t mode = 1; mode < modes_; ++mode) {
      if (original_.to_mode == mode) continue;
      if (original_.to_mode == kKeep && original_.from == in(State::operational) &&
          original_.modes == 1u << mode)
        continue;
      Row row = original_;
      row.to = State::operational;
      row.to_mode = mode;
      if (row.to_goal == kKeep) row.to_goal = 0;
      attempt(Change::redirected, row, fmt::format("to {}", vehicle_.mode_names[mode]));
    }
    if ((original_.from & in(State::operational)) == 0 && original_.to != State::operational)
      return;
    for (std::uint8_t goal = 0; goal < goals_; ++goal) {
      if (original_.to_goal == goal || (original_.to_goal == kKeep && original_.goal == goal))
        continue;
      Row row = original_;
      row.to_goal = goal;
      attempt(Change::redirected, row, fmt::format("to goal {}", vehicle_.goal_names[goal]));
    }
  }

  void loosen() {
    for (unsigned bit = 0; original_.guards >> bit != 0; ++bit) {
      if ((unsigned{original_.guards} >> bit & 1u) == 0) continue;
      Row row = original_;
      row.guards = static_cast<GuardSet>(row.guards & ~guard(bit));
      attempt(Change::loosened, row, fmt::format("without guard {}", bit));
    }
  }

  void idle() {
    for (unsigned bit = 0; original_.actions >> bit != 0; ++bit) {
      if ((original_.actions >> bit & 1u) == 0) continue;
      Row row = original_;
      row.actions &= ~(ActionSet{1} << bit);
      attempt(Change::idle, row, fmt::format("without action {}", bit));
    }
  }

  void widen() {
    for (unsigned s = 0; s < 4; ++s) {
      const auto state = static_cast<State>(s);
      if ((original_.from & in(state)) != 0) continue;
      if (state == State::operational && original_.modes != kAnyMode) continue;
      Row row = original_;
      row.from = static_cast<StateSet>(row.from | in(state));
      attempt(Change::widened, row, fmt::format("also from {}", kStateNames[s]));
    }
    const bool operational = (original_.from & in(State::operational)) != 0;
    for (unsigned mode = 1; mode < modes_; ++mode) {
      if (original_.modes == kAnyMode || (operational && (original_.modes >> mode & 1u) != 0))
        continue;
      Row row = original_;
      row.from = static_cast<StateSet>(row.from | in(State::operational));
      row.modes = (operational ? row.modes : 0) | 1u << mode;
      attempt(Change::widened, row, fmt::format("also from {}", vehicle_.mode_names[mode]));
    }
  }

  void busy() {
    ActionSet all = 0;
    for (const Rows* rows : {table_.common, table_.rows}) {
      for (const Row& row : rows->rows) all |= row.actions;
    }
    for (unsigned bit = 0; all >> bit != 0; ++bit) {
      if ((all >> bit & 1u) == 0 || (original_.actions >> bit & 1u) != 0) continue;
      Row row = original_;
      row.actions |= ActionSet{1} << bit;
      attempt(Change::busy, row, fmt::format("with action {}", bit));
    }
  }

  const Verified& vehicle_;
  const Table& table_;
  std::uint8_t modes_, goals_;
  std::size_t row_ = 0;
  Row original_{};
  Mutations result_;
};

}  // namespace

Mutations::Count Mutations::sum() const {
  Count sum;
  for (const Count& count : of) {
    sum.all += count.all;
    sum.caught += count.caught;
    sum.equivalent += count.equivalent;
    sum.demanded += count.demanded;
  }
  return sum;
}

Mutations mutate(const Verified& vehicle) { return Measure(vehicle).run(); }

}  // namespace lss::lc
