#pragma once

// The results of a campaign, or of one shard of it, as a file (JSON) that `lss-campaign merge` adds
// up. Errors are thrown as std::runtime_error with a sentence.

#include <filesystem>
#include <string>
#include <vector>

#include "tests/campaign/report.h"

namespace lss::campaign {

// Of `of` computers, this one plays each `of`th scenario, beginning with the `number`th.
struct Shard {
  unsigned number = 1, of = 1;
};
Shard parse_shard(const std::string& text);  // "2/8"

struct Results {
  std::string commit;            // of the sources; "": not known
  unsigned first = 1, runs = 0;  // of the whole campaign
  Shard shard;                   // of: 1 when it is all of it
  std::vector<Summary> summaries;
};

std::string to_text(const Results& results);
Results from_text(const std::string& text, const std::string& name);
void write(const Results& results, const std::filesystem::path& path);
Results read(const std::filesystem::path& path);

// All shards of one campaign: refused when one is missing, comes twice, or is of another campaign
// or commit.
Results merge(const std::vector<Results>& shards);

}  // namespace lss::campaign
