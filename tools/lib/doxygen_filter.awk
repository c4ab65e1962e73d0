# Shows Doxygen our plain comments as its own: // above something, // behind something, and the first of a file,
# which says what the file is for. Doxygen's INPUT_FILTER; docs/CMakeLists.txt.
{
  behind = match($0, /[;,{)] +\/\/ /)
  if ($0 ~ /^ *\/\/ /) {
    column = index($0, "//")
    if (column == column_behind) {  # goes on behind the line above
      sub(/\/\/ /, "///< ")
    } else {
      if (!described && NR > 1) print "/// @file"
      described = 1
      sub(/\/\/ /, "/// ")
      column_behind = 0
    }
  } else if ($0 ~ /^ *\/\/$/) {
    sub(/\/\/$/, "///")
  } else if (behind) {
    column_behind = index($0, "// ")
    sub(/\/\/ /, "///< ")
  } else {
    column_behind = 0
    if ($0 ~ /^#include|^namespace/) described = 1
  }
  print
}
