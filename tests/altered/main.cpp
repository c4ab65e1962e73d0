// lssd --replay with altered numbers (CMakeLists.txt names them): its outputs must differ from a
// recording of lssd.

#include <cstdio>

#include "daemon/replay/replay_files.h"

int main(int argc, char** argv) {
  const auto print = [](const std::string& line) { std::fputs(line.c_str(), stdout); };
  return static_cast<int>(
      lss::record::replay_files(std::vector<std::filesystem::path>(argv + 1, argv + argc), print));
}
