#pragma once

// Date and commit of the sources, for pages that programs of the tree make.

#include <cstdio>
#include <ctime>
#include <filesystem>
#include <string>

namespace lss::testing_support {

// Of the sources around this file, with a word when they differ from it; "": not under git.
inline std::string commit_around(const std::filesystem::path& file) {
  const std::string git = "git -C '" + std::filesystem::absolute(file).parent_path().string() + "'";
  const std::string command = "(" + git + " rev-parse --short HEAD && (" + git +
                              " diff --quiet HEAD -- ':/' ':!/docs' || echo changed)) 2>&-";
  std::string text;
  if (std::FILE* pipe = popen(command.c_str(), "r")) {
    for (int c; (c = std::fgetc(pipe)) != EOF;) text += c == '\n' ? ' ' : static_cast<char>(c);
    pclose(pipe);
  }
  if (!text.empty()) text.pop_back();
  return text;
}

// "2026-11-24 at commit 1a2b3c4"; of a file that is not under git the date alone.
inline std::string stamp(const std::filesystem::path& file) {
  const std::time_t now = std::time(nullptr);
  std::tm date{};
  gmtime_r(&now, &date);
  char day[16];
  std::strftime(day, sizeof day, "%Y-%m-%d", &date);
  const std::string commit = commit_around(file);
  return commit.empty() ? day : std::string(day) + " at commit " + commit;
}

}  // namespace lss::testing_support
