#pragma once

// Configurations of a vehicle for tests: the shipped one (LSS_CONFIG is its path), and the same
// with some of its text replaced.

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

#include "daemon/config/config.h"
#include "daemon/cycle/tunables.h"

namespace lss::testing_support {

template <class Parameters>
class ConfigFile {
 public:
  using Loaded = tl::expected<config::Config, std::string>;

  ConfigFile(const char* vehicle, Parameters (*read)(config::Section&))
      : vehicle_(vehicle), read_(read) {}

  Loaded load(const std::string& file, Parameters& parameters) const {
    return config::load(file, {vehicle_},
                        [&](const std::string&, config::Section& s) { parameters = read_(s); });
  }
  // The shipped one; its tunables are the defaults, but for one that is rounded for people.
  std::pair<config::Config, Parameters> defaults(const Tuning<Parameters>& tuning,
                                                 std::string_view rounded = "") const {
    Parameters parameters;
    Loaded config = load(LSS_CONFIG, parameters);
    EXPECT_TRUE(config) << config.error();
    const TunableValues read = values_of(tuning.tunables, parameters);
    const TunableValues defaults = values_of(tuning.tunables, Parameters{});
    for (std::size_t i = 0; i < tuning.infos.size(); ++i) {
      const std::string_view name = tuning.infos[i].name;
      const double share = name == rounded ? 1e-4 : 1e-12;
      EXPECT_NEAR(read.value[i], defaults.value[i], share * std::abs(defaults.value[i])) << name;
    }
    return {config.value(), parameters};
  }
  // A file of this text; its path.
  std::string file_of(const std::string& text) const {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    const std::string path = testing::TempDir() + vehicle_ + "_altered_" + test->name() + ".toml";
    std::ofstream(path) << text;
    return path;
  }
  // The shipped one with `from` replaced; its path.
  std::string altered(const std::string& from, const std::string& to) const {
    std::string text = text_of(LSS_CONFIG);
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    return file_of(text);
  }
  // Of such a file; "": it is taken.
  std::string error_of_text(const std::string& text) const { return error_in(file_of(text)); }
  std::string error_of(const std::string& from, const std::string& to) const {
    return error_in(altered(from, to));
  }
  static std::string text_of(const std::string& file) {
    std::ifstream in(file);
    return {std::istreambuf_iterator<char>(in), {}};
  }

 private:
  std::string error_in(const std::string& file) const {
    Parameters parameters;
    const Loaded config = load(file, parameters);
    return config ? "" : config.error();
  }

  std::string vehicle_;
  Parameters (*read_)(config::Section&);
};

}  // namespace lss::testing_support
