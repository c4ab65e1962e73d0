#include "tests/zebro/mission/faults.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

namespace lss::zebro::mission {

Faults::Faults(unsigned seed, double mean_h, bool lying)
    : random_(seed), mean_s_(mean_h * 3600), lying_(lying) {
  next_s_ = std::exponential_distribution(1 / mean_s_)(random_);
}

double Faults::uniform(double from, double to) {
  return std::uniform_real_distribution(from, to)(random_);
}

std::optional<DueFault> Faults::begin(double operated_s, double now_s) {
  if (operated_s < next_s_) return {};
  next_s_ += std::exponential_distribution(1 / mean_s_)(random_);
  std::array<double, kFaultShapes.size()> weights{};
  for (std::size_t i = 0; i < weights.size(); ++i)
    weights[i] = lying_ || !kFaultShapes[i].lies ? kFaultShapes[i].weight : 0;
  DueFault due;
  due.shape = std::discrete_distribution<std::size_t>(weights.begin(), weights.end())(random_);
  const FaultShape& shape = kFaultShapes[due.shape];
  due.attach = shape.name;
  std::string clear = fmt::format("clear:{}", shape.name);
  if (shape.last_unit > 0) {
    due.unit = std::uniform_int_distribution(1, shape.last_unit)(random_);
    due.attach += fmt::format(":{}", due.unit);
    clear += fmt::format(":{}", due.unit);
  }
  // Long and short ones are as frequent: the logarithm is uniform.
  const double lasts_s =
      shape.to_s > 0 ? std::exp(uniform(std::log(shape.from_s), std::log(shape.to_s))) : 0;
  if (shape.most > 0) due.attach += fmt::format(":{:.4f}", uniform(shape.least, shape.most));
  if (due.attach == "unplug") {
    due.attach += fmt::format(":{:.3f}", lasts_s);  // ends by itself
    return due;
  }
  const bool for_good = uniform(0, 1) < shape.for_good;
  if (lasts_s > 0) {
    active_.push_back(
        {due.attach, clear, for_good ? std::numeric_limits<double>::infinity() : now_s + lasts_s});
  }
  return due;
}

std::vector<std::string> Faults::attached() const {
  std::vector<std::string> texts;
  for (const Active& fault : active_) texts.push_back(fault.attach);
  return texts;
}

std::vector<std::string> Faults::end(double now_s) {
  std::vector<std::string> over;
  std::erase_if(active_, [&](const Active& fault) {
    if (fault.until_s > now_s) return false;
    over.push_back(fault.clear);
    return true;
  });
  return over;
}

}  // namespace lss::zebro::mission
