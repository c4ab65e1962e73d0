#include "tests/bench/bench.h"

#include <algorithm>
#include <numeric>

namespace lss::bench {

double quantile(Samples samples, double q) {
  if (samples.empty()) return kNone;
  const auto index = static_cast<std::size_t>(
      std::min(q * static_cast<double>(samples.size()), static_cast<double>(samples.size() - 1)));
  std::ranges::nth_element(samples, samples.begin() + static_cast<std::ptrdiff_t>(index));
  return samples[index];
}

double median(const Samples& samples) { return quantile(samples, 0.5); }
double p99(const Samples& samples) { return quantile(samples, 0.99); }

double sigma(const Samples& samples) {
  if (samples.empty()) return kNone;
  const double n = static_cast<double>(samples.size());
  const double mean = std::accumulate(samples.begin(), samples.end(), 0.0) / n;
  double squares = 0;
  for (const double s : samples) squares += (s - mean) * (s - mean);
  return std::sqrt(squares / n);
}

namespace {

Samples joined(Samples a, const Samples& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

// Part `index` of `parts`, as equal as they can be.
Samples part(const Samples& all, std::size_t index, std::size_t parts) {
  const auto at = [&](std::size_t i) {
    return all.begin() + static_cast<std::ptrdiff_t>(i * all.size() / parts);
  };
  return {at(index), at(index + 1)};
}

}  // namespace

Rounds turn_by_turn(const std::function<Samples()>& subject,
                    const std::function<Samples()>& reference, int count) {
  Rounds rounds;
  for (int i = 0; i < count; ++i) {
    Round round;
    round.reference = reference();
    round.value = subject();
    round.value = joined(std::move(round.value), subject());
    round.again = reference();
    rounds.push_back(std::move(round));
  }
  return rounds;
}

Rounds side_by_side(const Samples& subject, const Samples& reference) {
  Rounds rounds;
  for (std::size_t i = 0; i < kRounds; ++i) {
    const Samples both = part(reference, i, kRounds);
    rounds.push_back({.value = part(subject, i, kRounds),
                      .reference = part(both, 0, 2),
                      .again = part(both, 1, 2)});
  }
  return rounds;
}

Cycles with_incomplete(const Samples& newest_us, double period_us) {
  Cycles all;
  for (std::size_t i = 1; i < newest_us.size(); ++i) {
    const bool ended = newest_us[i] != newest_us[i - 1];
    all.us.push_back(ended ? newest_us[i] : period_us);
    all.incomplete += ended ? 0 : 1;
  }
  return all;
}

std::string Figure::remark() const {
  if (held_back.empty() || met().value_or(Met::yes) == Met::yes) return note;
  return note + (note.empty() ? "" : "; ") + "bottleneck: " + held_back;
}

std::optional<Met> Figure::met() const {
  const auto decided = [](bool is) { return is ? Met::yes : Met::no; };
  if (!std::isfinite(goal) || !std::isfinite(value)) return {};
  if (absolute) return decided(value <= goal);
  if (std::isfinite(ratio)) {
    const bool is = ratio <= goal;
    const double scatter = aa_ratio > 0 ? std::max(aa_ratio, 1 / aa_ratio) : 1;
    const bool still = (is ? ratio * scatter : ratio / scatter) <= goal;
    return still == is ? decided(is) : Met::undecided;
  }
  if (!std::isfinite(reference)) return {};
  return decided(value <= goal * reference);  // both are zero
}

Figure figure(const std::string& row, const std::string& name, const std::string& unit,
              const Rounds& rounds, const Statistic& statistic, double goal) {
  Samples values, references, ratios, aa;
  for (const Round& round : rounds) {
    const double value = statistic(round.value);
    const double reference = statistic(joined(round.reference, round.again));
    if (!std::isfinite(value) || !std::isfinite(reference)) continue;  // a side has no sample
    values.push_back(value);
    references.push_back(reference);
    if (reference > 0) ratios.push_back(value / reference);
    if (statistic(round.reference) > 0)
      aa.push_back(statistic(round.again) / statistic(round.reference));
  }
  return {.row = row,
          .name = name,
          .unit = unit,
          .value = median(values),
          .reference = median(references),
          .ratio = median(ratios),
          .aa_ratio = median(aa),
          .goal = goal,
          .note = values.empty() ? "not measured: no sample of both sides" : ""};
}

Figure figure_of(const std::string& row, const std::string& name, const std::string& unit,
                 double value, double reference, double goal, const std::string& note) {
  return {.row = row,
          .name = name,
          .unit = unit,
          .value = value,
          .reference = reference,
          .ratio = reference > 0 ? value / reference : kNone,
          .goal = goal,
          .note = note};
}

Figure most(const std::string& row, const std::string& name, const std::string& unit,
            const Rounds& rounds) {
  double value = -INFINITY, reference = -INFINITY, again = -INFINITY;
  for (const Round& round : rounds) {
    value = std::max(value, quantile(round.value, 1));
    reference = std::max(reference, quantile(round.reference, 1));
    again = std::max(again, quantile(round.again, 1));
  }
  Figure made = figure_of(row, name, unit, value, std::max(reference, again), kNone);
  if (reference > 0) made.aa_ratio = again / reference;
  return made;
}

Figure missed(const std::string& row, const std::string& name, const Rounds& rounds, double bound) {
  std::ptrdiff_t value = 0, reference = 0;
  const auto over = [bound](const Samples& samples) {
    return std::ranges::count_if(samples, [bound](double sample) { return sample > bound; });
  };
  for (const Round& round : rounds) {
    value += over(round.value);
    reference += over(round.reference) + over(round.again);
  }
  return to_be_none(
      figure_of(row, name, "1", static_cast<double>(value), static_cast<double>(reference), kNone));
}

Figure at_most(Figure figure, double goal) {
  figure.goal = goal;
  figure.absolute = true;
  return figure;
}

Figure to_be_none(Figure figure) { return at_most(std::move(figure), 0); }

Figure noted(Figure figure, const std::string& note) {
  if (std::isfinite(figure.value)) figure.note = note;
  return figure;
}

Figure held_back(Figure figure, const std::string& by) {
  figure.held_back = by;
  return figure;
}

Figure not_measured(const std::string& row, const std::string& name, const std::string& why) {
  return {.row = row, .name = name, .unit = "", .note = "not measured: " + why};
}

}  // namespace lss::bench
