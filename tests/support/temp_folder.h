#pragma once

// A folder of a test, and the content of its files. Its own name in the system's folder for
// temporary files; gone at the end.

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

namespace lss::testing_support {

class TempFolder : public std::filesystem::path {
 public:
  TempFolder() : path(make()) {}
  ~TempFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(*this, ignored);
  }
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;

  // By name.
  std::vector<path> files() const {
    std::vector<path> found;
    for (const auto& entry : std::filesystem::directory_iterator(*this))
      found.push_back(entry.path());
    std::ranges::sort(found);
    return found;
  }

 private:
  static std::string make() {
    std::string name = (std::filesystem::temp_directory_path() / "lss-test-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot make " + name);
    return name;
  }
};

inline std::string content(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline void put_content(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << text;
}

}  // namespace lss::testing_support
