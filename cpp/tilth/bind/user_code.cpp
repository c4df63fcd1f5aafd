// SPDX-License-Identifier: BSD-3-Clause
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "../user_code.hpp"
#include "checked.hpp"

namespace tilth::bind {
namespace {

/// Code of the user that Python calls, as a context.
class UserCode {
 public:
  explicit UserCode(std::string name) : name_(std::move(name)) {}

  void enter() {
    exit();
    around_ = std::make_unique<user_code::Around>();
    running_ = std::make_unique<user_code::Running>(name_.c_str());
  }
  void exit() {
    running_.reset();
    around_.reset();
  }

 private:
  std::string name_;
  std::unique_ptr<user_code::Around> around_;
  std::unique_ptr<user_code::Running> running_;
};

/// Sets what is said when code of the user ends the process. All notes stay in memory to the very
/// end: a signal handler, or one of `exit`, may be reading one.
void set_note(const std::string& kept, int file) {
  static auto& mutex = *new std::mutex;
  static auto& all = *new std::deque<user_code::Note>;
  const std::lock_guard lock(mutex);
  const user_code::Note* now = user_code::note.load();
  if (now != nullptr && now->kept == kept && now->file == file) return;
  user_code::note.store(&all.emplace_back(kept, file));
}

}  // namespace

void bind_user_code(nb::module_& module) {
  nb::class_<UserCode>(module, "UserCode",
                       "Context of code of the user. If it ends the process, this is said with the "
                       "name; the working folder is that of before at the end.")
      .def(nb::init<std::string>(), nb::arg("name"))
      .def("__enter__", &UserCode::enter)
      .def(
          "__exit__", [](UserCode& self, nb::args) { self.exit(); },
          nb::sig("def __exit__(self, *args: object) -> None"));
  module.def("set_user_code_note", &set_note, nb::arg("kept") = "", nb::arg("file") = -1,
             "Sets what is said of the results when code of the user ends the process, and a file "
             "that gets a line, -1 for none.");
}

}  // namespace tilth::bind
