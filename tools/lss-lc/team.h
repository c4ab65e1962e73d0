#pragma once

// Threads that share successive pieces of work. The caller is one of them and waits for the others:
// between two calls of run() no other thread runs.

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace lss::lc {

class Team {
 public:
  explicit Team(unsigned members) {
    for (unsigned member = 1; member < members; ++member)
      others_.emplace_back([this, member] { help(member); });
  }
  ~Team() {
    {
      const std::lock_guard lock(mutex_);
      over_ = true;
    }
    changed_.notify_all();
  }
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  unsigned members() const { return static_cast<unsigned>(others_.size()) + 1; }

  // work(i, member) for each i below count. The indices of a member increase; the distribution is
  // not defined.
  using Work = std::function<void(std::size_t i, unsigned member)>;
  void run(std::size_t count, const Work& work) {
    next_ = 0;
    if (count > 1 && !others_.empty()) {
      {
        const std::lock_guard lock(mutex_);
        work_ = &work;
        count_ = count;
        busy_ = others_.size();
        ++round_;
      }
      changed_.notify_all();
      share(work, count, 0);
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return busy_ == 0; });
    } else {
      share(work, count, 0);
    }
  }

 private:
  void share(const Work& work, std::size_t count, unsigned member) {
    for (std::size_t i = next_++; i < count; i = next_++) work(i, member);
  }
  void help(unsigned member) {
    std::unique_lock lock(mutex_);
    for (std::size_t seen = 0;;) {
      changed_.wait(lock, [&] { return over_ || round_ != seen; });
      if (over_) return;
      seen = round_;
      const Work& work = *work_;
      const std::size_t count = count_;
      lock.unlock();
      share(work, count, member);
      lock.lock();
      if (--busy_ == 0) changed_.notify_all();
    }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  const Work* work_ = nullptr;
  std::size_t count_ = 0, busy_ = 0, round_ = 0;
  bool over_ = false;
  std::atomic<std::size_t> next_{0};
  std::vector<std::jthread> others_;  // last: they use the other members
};

}  // namespace lss::lc
