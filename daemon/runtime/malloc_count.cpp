// The allocator of the daemon's program: glibc's, with a count per thread, so that status reports
// the allocations of a real-time thread since start (must be 0). Linked into lssd and tests that
// need it; not under sanitizers, which have their own allocator.

#include <cstddef>

#include "daemon/runtime/thread.h"

#ifndef LSS_SANITIZED

extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* old, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) {
  lss::rt::count_malloc();
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  lss::rt::count_malloc();
  return __libc_calloc(count, size);
}
void* realloc(void* old, std::size_t size) {
  lss::rt::count_malloc();
  return __libc_realloc(old, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  lss::rt::count_malloc();
  return __libc_memalign(alignment, size);
}
}

#endif
