#include "tools/lss-cli/show/timing.h"

#include <algorithm>

namespace lss::cli {
namespace {

nlohmann::json series_json(const TimingSeries& s) {
  nlohmann::json buckets = nlohmann::json::array();
  for (std::size_t i = 0; i < TimingSeries::kBuckets; ++i) {
    if (s.bucket[i] != 0)
      buckets.push_back({{"from_us", us(static_cast<double>(TimingSeries::lower_ns(i)))},
                         {"to_us", us(static_cast<double>(TimingSeries::lower_ns(i + 1)))},
                         {"count", s.bucket[i]}});
  }
  return {{"count", s.count},
          {"mean_us", us(s.mean_ns())},
          {"sigma_us", us(s.sigma_ns())},
          {"min_us", us(static_cast<double>(s.min_ns))},
          {"p50_us", us(s.quantile_ns(0.5))},
          {"p99_us", us(s.quantile_ns(0.99))},
          {"p999_us", us(s.quantile_ns(0.999))},
          {"max_us", us(static_cast<double>(s.max_ns))},
          {"histogram", std::move(buckets)}};
}

}  // namespace

TimingStatistics to_statistics(const lss_TimingStatistics& from) {
  TimingStatistics to{.frames = from.frames,
                      .overruns = from.overruns,
                      .repeated = from.repeated,
                      .skipped = from.skipped,
                      .held = from.held,
                      .since_ns = from.since_ns,
                      .until_ns = from.until_ns,
                      .period_ns = from.period_ns,
                      .offset_ns = from.offset_ns};
  for (std::size_t i = 0; i < kTimingStepCount; ++i) {
    TimingSeries& series = to.series[i];
    series.count = from.series[i].count;
    series.sum_ns = from.series[i].sum_ns;
    series.squares_ns2 = from.series[i].squares_ns2;
    series.min_ns = from.series[i].min_ns;
    series.max_ns = from.series[i].max_ns;
    std::copy_n(from.series[i].bucket, TimingSeries::kBuckets, series.bucket.begin());
  }
  return to;
}

nlohmann::json timing_json(const TimingStatistics& all) {
  nlohmann::json steps = nlohmann::json::object();
  for (std::size_t i = 0; i < kTimingStepCount; ++i) {
    if (all.series[i].count != 0) steps[kTimingSteps[i].name] = series_json(all.series[i]);
  }
  const TimingSeries& command = all.series[4];
  nlohmann::json margin;  // null: no frame yet
  if (all.frames != 0) {
    margin = {{"mean_us", us(all.margin_ns(command.mean_ns()))},
              {"p999_us", us(all.margin_ns(command.quantile_ns(0.999)))},
              {"min_us", us(all.margin_ns(static_cast<double>(command.max_ns)))}};
  }
  return {{"frames", all.frames},
          {"since_ns", all.since_ns},
          {"until_ns", all.until_ns},
          {"period_ns", all.period_ns},
          {"offset_ns", all.offset_ns},
          {"missed",
           {{"overruns", all.overruns},
            {"repeated", all.repeated},
            {"skipped", all.skipped},
            {"held", all.held}}},
          {"margin", std::move(margin)},
          {"points", std::move(steps)}};
}

}  // namespace lss::cli
