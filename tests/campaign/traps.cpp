#include "tests/campaign/traps.h"

#include <signal.h>
#include <sys/mman.h>
#include <sys/time.h>
#include <ucontext.h>

#include <atomic>
#include <stdexcept>

#ifdef __x86_64__
#include <x86intrin.h>

// Of the section of this file, which is not counted; the linker names them.
extern "C" const char __start_lss_traps, __stop_lss_traps;
#endif

namespace lss::campaign {
namespace {

// Since the start of this process, so that its copies tell it what they did.
void* const shared_page =
    mmap(nullptr, sizeof(Struck), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);

Struck& shared() {
  if (shared_page == MAP_FAILED) throw std::runtime_error("no memory to share");
  return *static_cast<Struck*>(shared_page);
}

#ifdef __x86_64__

constexpr unsigned long long kTrapFlag = 1u << 8;

constexpr int kGeneral[] = {REG_RAX, REG_RBX, REG_RCX, REG_RDX, REG_RSI, REG_RDI,
                            REG_RBP, REG_RSP, REG_R8,  REG_R9,  REG_R10, REG_R11,
                            REG_R12, REG_R13, REG_R14, REG_R15, REG_RIP};
constexpr const char* kGeneralNames[] = {"rax", "rbx", "rcx", "rdx", "rsi", "rdi",
                                         "rbp", "rsp", "r8",  "r9",  "r10", "r11",
                                         "r12", "r13", "r14", "r15", "rip"};
constexpr unsigned kFlags[] = {0, 2, 4, 6, 7, 8, 10, 11, 18};  // that a program can set
constexpr std::uint64_t kWord = 64, kGenerals = kWord * std::size(kGeneral);
constexpr std::uint64_t kControl = 16, kVector = 128, kVectors = 16;  // mxcsr; xmm0 to xmm15
constexpr std::uint64_t kControlAt = kGenerals + std::size(kFlags),
                        kVectorsAt = kControlAt + kControl, kAll = kVectorsAt + kVectors * kVector;
constexpr std::uint64_t kRedZone = 128;  // below the stack pointer, in use as well

// Plain arrays and no calls: begins() and ends() run between traps.
struct Watch {
  bool on = false, counts = false;
  unsigned depth = 0;
  std::size_t thread = 0;
  std::uintptr_t stack_end = 0, last = 0;
  std::uint64_t seen[kDaemonThreads.size()] = {}, most[kDaemonThreads.size()] = {};
  Hit hit{};
} watch;

void flip_register(ucontext_t& context, std::uint64_t bit) {
  greg_t* const general = context.uc_mcontext.gregs;
  const auto change = [&](int number, std::uint64_t bits) {
    general[number] = static_cast<greg_t>(static_cast<std::uint64_t>(general[number]) ^ bits);
  };
  _libc_fpstate& floating = *context.uc_mcontext.fpregs;
  if (bit < kGenerals) {
    change(kGeneral[bit / kWord], std::uint64_t{1} << bit % kWord);
  } else if (bit < kControlAt) {
    change(REG_EFL, std::uint64_t{1} << kFlags[bit - kGenerals]);
  } else if (bit < kVectorsAt) {
    floating.mxcsr ^= 1u << (bit - kControlAt);
  } else {
    const std::uint64_t at = bit - kVectorsAt;
    floating._xmm[at / kVector].element[at % kVector / 32] ^= 1u << at % 32;
  }
}

void flip_stack(std::uintptr_t top, std::uintptr_t end) {
  if (top >= end) return;
  const auto byte = static_cast<std::uintptr_t>(watch.hit.place * static_cast<double>(end - top));
  auto* const at = reinterpret_cast<std::uint8_t*>(top + byte);
  *at = static_cast<std::uint8_t>(*at ^ 1u << watch.hit.bit);
}

// Before each instruction of a thread's work. On a stack of its own.
void on_trap(int, siginfo_t*, void* data) {
  ucontext_t& context = *static_cast<ucontext_t*>(data);
  greg_t* const general = context.uc_mcontext.gregs;
  const auto at = static_cast<std::uintptr_t>(general[REG_RIP]);
  if (at >= reinterpret_cast<std::uintptr_t>(&__start_lss_traps) &&
      at < reinterpret_cast<std::uintptr_t>(&__stop_lss_traps))
    return;
  if (at == watch.last) return;  // copying by one instruction stops at each piece
  watch.last = at;
  std::uint64_t& seen = watch.seen[watch.thread];
  const std::uint64_t most = watch.counts ? watch.most[watch.thread] : watch.hit.instruction;
  if (seen < most) {
    ++seen;
    return;
  }
  general[REG_EFL] &= ~static_cast<greg_t>(kTrapFlag);
  if (watch.counts) return;
  watch.on = false;
  signal(SIGTRAP, SIG_DFL);
  shared() = {.happened = true, .instruction = at};
  allow_cpu();
  if (watch.hit.stack)
    flip_stack(static_cast<std::uintptr_t>(general[REG_RSP]) - kRedZone, watch.stack_end);
  else
    flip_register(context, watch.hit.bit);
}

[[gnu::section("lss_traps"), gnu::noinline]] void begins(DaemonThread thread, void* stack_end) {
  if (!watch.on || watch.depth++ != 0) return;
  const auto number = static_cast<std::size_t>(thread);
  if (watch.counts ? watch.seen[number] >= watch.most[number] : thread != watch.hit.thread) return;
  watch.thread = number;
  watch.stack_end = reinterpret_cast<std::uintptr_t>(stack_end);
  watch.last = 0;
  std::atomic_signal_fence(std::memory_order_seq_cst);
  __writeeflags(__readeflags() | kTrapFlag);
}

[[gnu::section("lss_traps"), gnu::noinline]] void ends() {
  if (!watch.on || --watch.depth != 0) return;
  __writeeflags(__readeflags() & ~kTrapFlag);
  std::atomic_signal_fence(std::memory_order_seq_cst);
}

void begin_to_watch() {
  constexpr std::size_t kStack = 1 << 16;
  alignas(64) static std::array<std::uint8_t, kStack> own;
  stack_t stack{};
  stack.ss_sp = own.data();
  stack.ss_size = own.size();
  struct sigaction action {};
  action.sa_sigaction = on_trap;
  action.sa_flags = SA_SIGINFO | SA_ONSTACK;
  if (sigaltstack(&stack, nullptr) != 0 || sigaction(SIGTRAP, &action, nullptr) != 0)
    throw std::runtime_error("SIGTRAP cannot be handled");
  testing_support::work_begins = begins;
  testing_support::work_ends = ends;
  watch.on = true;
}

#endif

}  // namespace

Struck struck() { return shared(); }

void allow_cpu(unsigned seconds) {
  itimerval limit{};
  limit.it_value.tv_sec = seconds;
  setitimer(ITIMER_PROF, &limit, nullptr);  // then SIGPROF
}

#ifdef __x86_64__

RegisterBits all_registers() { return {0, kAll}; }

std::string register_of(std::uint64_t bit) {
  if (bit < kGenerals) return kGeneralNames[bit / kWord];
  if (bit < kControlAt) return "flags";
  if (bit < kVectorsAt) return "mxcsr";
  return "xmm" + std::to_string((bit - kVectorsAt) / kVector);
}

RegisterBits register_bits(const std::string& name) {
  RegisterBits found;
  for (std::uint64_t bit = 0; bit < kAll; ++bit) {
    if (register_of(bit) != name) continue;
    if (found.count == 0) found.first = bit;
    ++found.count;
  }
  return found;
}

std::uint64_t processor_modes() {
  constexpr std::uint64_t kDirection = 1u << 10, kAlignment = 1u << 18;
  constexpr unsigned kSeen = 0x3f;  // of mxcsr: what happened so far
  return (__readeflags() & (kDirection | kAlignment)) << 32 | (_mm_getcsr() & ~kSeen);
}

void expect(const Hit& hit) {
  shared() = {};
  watch = {};
  watch.hit = hit;
  begin_to_watch();
}

Instructions count_instructions(const std::function<void()>& run, const Instructions& most) {
  watch = {};
  watch.counts = true;
  for (std::size_t i = 0; i < most.size(); ++i) watch.most[i] = most[i];
  begin_to_watch();
  run();
  watch.on = false;
  Instructions all{};
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = watch.seen[i];
  return all;
}

#else

RegisterBits all_registers() { return {}; }
std::string register_of(std::uint64_t) { return {}; }
std::uint64_t processor_modes() { return 0; }
RegisterBits register_bits(const std::string&) { return {}; }
void expect(const Hit&) { throw std::runtime_error("registers are flipped on amd64 only"); }
Instructions count_instructions(const std::function<void()>&, const Instructions&) {
  throw std::runtime_error("instructions are counted on amd64 only");
}

#endif

}  // namespace lss::campaign
