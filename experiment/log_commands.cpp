// Options of each subcommand, then its words.
#include "experiment/log_commands.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <iostream>
#include <unistd.h>

#include "base/error.h"
#include "base/program.h"
#include "experiment/export_log.h"
#include "experiment/merge_logs.h"
#include "experiment/status.h"
#include "experiment/withdraw.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

struct StatusOptions {
  std::string folder;
};

struct ExportOptions {
  std::string folder;
  std::string out;
  std::string format = "csv";
  std::string kind = "person";
  bool force = false;
};

struct WithdrawOptions {
  std::string log;
  std::string code;
  bool yes = false;
};

struct MergeOptions {
  std::string folder;
  std::vector<std::string> logs;
  std::vector<std::string> renames;
  bool yes = false;
};

int show_status(const StatusOptions& options) {
  fmt::print("{}", format_status(StudyFolder{options.folder}));
  return kExitOk;
}

std::string count_sessions(const TrialLog& log) {
  std::map<SubjectKind, int> counts;
  for (const SessionRow& row : log.load_sessions()) ++counts[row.kind];
  std::vector<std::string> words;
  for (const auto& [kind, count] : counts)
    words.push_back(fmt::format("{} of kind {}", count, format_kind(kind)));
  return words.empty() ? "no session" : fmt::format("{}", fmt::join(words, ", "));
}

// A log that cannot be written can be exported all the same, but then no withdrawal will name these files.
void record_export(const fs::path& log, const std::string& path) {
  try {
    TrialLog(log).append_export(path);
  } catch (const StoreError& error) {
    fmt::print(stderr,
               "equilux-session: this export is not recorded in the log, so that a withdrawal will not name "
               "it: {}\n",
               error.what());
  }
}

int export_log(const ExportOptions& options) {
  const StudyFolder folder{options.folder};
  const Study study = load_folder_study(folder);
  const SubjectKind kind = parse_kind(options.kind, "--kind");
  const TrialLog log = TrialLog::load_snapshot(folder.responses());
  const auto records = load_records(log, kind);
  if (records.empty()) {
    throw InputError(folder.responses().string(), "--kind", fmt::format("sessions of kind {}", options.kind),
                     count_sessions(log));
  }
  const ExportFiles files = options.format == "bids" ? make_bids_export(records, study, kind)
                                                     : make_csv_export(records, study, kind);
  check_can_export(options.out, options.force);
  const std::string out = find_export_folder(options.out).string();
  record_export(folder.responses(), out);
  save_export(out, files, options.force);
  fmt::print("{}: sessions of kind {}: {}, files: {}\n", out, options.kind, records.size(), files.size());
  return kExitOk;
}

// Only somebody who is there can say yes.
void confirm(const std::string& what, const std::string& word) {
  if (!::isatty(STDIN_FILENO))
    throw InputError("--yes", "", "this option, where there is no terminal to ask on",
                     "none; nothing was erased");
  fmt::print("{}Type {} to go on: ", what, word);
  std::fflush(stdout);
  std::string typed;
  std::getline(std::cin, typed);
  if (typed != word)
    throw InputError("confirmation", "", word, fmt::format("\"{}\"; nothing was erased", typed));
}

// A study folder stands for its log.
fs::path log_of(const std::string& name) {
  return fs::is_directory(name) ? StudyFolder{name}.responses() : fs::path(name);
}

int withdraw(const WithdrawOptions& options) {
  const fs::path log = log_of(options.log);
  const Withdrawal withdrawal = plan_withdrawal(log, options.code);
  fmt::print("{}", format_withdrawal(withdrawal));
  std::fflush(stdout);
  if (!options.yes) confirm("", options.code);
  withdraw_participant(log, options.code);
  fmt::print("{} is erased from {}.\n", options.code, log.string());
  return kExitOk;
}

int merge(const MergeOptions& options) {
  const StudyFolder folder{options.folder};
  const Study study = load_folder_study(folder);
  std::vector<fs::path> others;
  for (const std::string& name : options.logs) others.push_back(log_of(name));
  std::vector<Rename> renames;
  for (const std::string& text : options.renames) renames.push_back(parse_rename(text));
  const MergePlan plan = plan_merge(folder.responses(), others, study.digest, renames);
  check_no_conflict(plan, folder.responses());
  if (!plan.erased.empty() && !options.yes)
    confirm(fmt::format("{} withdrew at another station and will be erased here.\n",
                        fmt::join(plan.erased, ", ")),
            "erase");
  const MergePlan done = merge_logs(folder.responses(), others, study.digest, renames);
  fmt::print("{}", format_merge(done));
  if (!done.erased.empty())
    fmt::print("{}", format_exports(TrialLog::load_snapshot(folder.responses()).load_exports()));
  return kExitOk;
}

CLI::App* add_command(CLI::App& app, const char* name, const char* what, std::string& folder,
                      const char* example) {
  CLI::App* command = app.add_subcommand(name, what);
  command->add_option("folder", folder, "Study folder")->required()->type_name("DIR");
  command->footer(fmt::format("Example: equilux-session {}", example));
  return command;
}

void add_export(CLI::App& app, ExportOptions& options) {
  CLI::App* command = add_command(app, "export", "Answers as tidy CSV, or as a BIDS folder", options.folder,
                                  "export studies/pocket --out pocket-answers");
  command->add_option("--out", options.out, "Folder to make")->required()->type_name("FOLDER");
  command->add_option("--format", options.format, "csv if not given")->check(CLI::IsMember({"csv", "bids"}));
  command->add_option("--kind", options.kind, "Who answered; person if not given")
      ->check(CLI::IsMember({"person", "planted", "looking"}));
  command->add_flag("--force", options.force, "Replace an earlier export");
}

void add_withdraw(CLI::App& app, WithdrawOptions& options) {
  CLI::App* command = app.add_subcommand("withdraw", "Erases a participant's answers for good");
  command->add_option("log", options.log, "Study folder, or a log by itself, such as one that was archived")
      ->required()
      ->type_name("DIR|FILE");
  command->footer("Example: equilux-session withdraw studies/pocket P01");
  command->add_option("code", options.code, "Code of the participant")->required()->type_name("CODE");
  command->add_flag("--yes", options.yes, "Do not ask");
}

void add_merge(CLI::App& app, MergeOptions& options) {
  CLI::App* command = add_command(app, "merge", "Takes in the sessions of other stations' logs",
                                  options.folder, "merge studies/pocket station2/responses.sqlite");
  command->add_option("logs", options.logs, "Logs, or study folders that hold one")
      ->required()
      ->type_name("LOG");
  command
      ->add_option(
          "--rename", options.renames,
          "Another code for a participant of the logs that come in, where somebody else has this one")
      ->type_name("OLD=NEW")
      ->allow_extra_args(false);
  command->add_flag("--yes", options.yes, "Do not ask before erasing who withdrew at another station");
}

}  // namespace

struct LogCommands::Impl {
  CLI::App& app;
  StatusOptions status = {};
  ExportOptions exporting = {};
  WithdrawOptions withdrawing = {};
  MergeOptions merging = {};
};

LogCommands::LogCommands(CLI::App& app) : impl_(std::make_unique<Impl>(Impl{app})) {
  add_command(app, "status", "Who has answered how much", impl_->status.folder, "status studies/pocket");
  add_export(app, impl_->exporting);
  add_withdraw(app, impl_->withdrawing);
  add_merge(app, impl_->merging);
}

LogCommands::~LogCommands() = default;

std::optional<int> LogCommands::run() const {
  if (impl_->app.got_subcommand("status")) return show_status(impl_->status);
  if (impl_->app.got_subcommand("export")) return export_log(impl_->exporting);
  if (impl_->app.got_subcommand("withdraw")) return withdraw(impl_->withdrawing);
  if (impl_->app.got_subcommand("merge")) return merge(impl_->merging);
  return std::nullopt;
}

}  // namespace equilux
