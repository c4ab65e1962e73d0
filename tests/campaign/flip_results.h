#pragma once

// The outcomes of flips as a file (JSON) of lss-campaign --flips --out, and their sum over seeds.
// Errors are thrown as std::runtime_error with a sentence.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "tests/campaign/flips.h"

namespace lss::campaign {

struct FlipResults {
  std::string commit;  // of the sources; "": not known
  std::string part;    // that was asked for
  bool protect = true;
  std::vector<unsigned> seeds;
  std::map<std::string, FlipCounts> vehicles;
};

std::string to_text(const FlipResults& results);
FlipResults flips_from_text(const std::string& text, const std::string& name);
void write(const FlipResults& results, const std::filesystem::path& path);
FlipResults read_flips(const std::filesystem::path& path);
bool is_flips(const std::filesystem::path& path);

// Refused: another commit or part, a vehicle's seed that comes twice.
FlipResults merge(const std::vector<FlipResults>& all);

// The tables of all vehicles.
std::string document(const FlipResults& results);

}  // namespace lss::campaign
