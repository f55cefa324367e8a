// parloc merge: the results of shards as one, by the command that they are parts of.
#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "common/error.h"
#include "tools/program/commands.h"
#include "tools/program/typed_command.h"
#include "tools/shards/shard_file.h"

namespace parloc::tools {
namespace {

struct MergeOptions {
  std::vector<std::string> folders;
  std::string out;
  bool json = false, quiet = false;
};

}  // namespace

Command add_merge_command(CLI::App& program,
                          const std::function<int(const std::vector<std::string>& words)>& run_words) {
  CLI::App* app = program.add_subcommand("merge", "Results of evaluate's or compare's shards, as one");
  const auto o = std::make_shared<MergeOptions>();
  app->add_option("DIRS", o->folders, "Folders of all shards: what --out said")->required()->type_name("");
  add_text_option(*app, "--out", o->out, "DIR", "Write what the whole run would have written there");
  app->add_flag("--json", o->json, "Print the JSON instead of the tables");
  app->add_flag("--quiet", o->quiet, "No tables");
  app->footer(
      "A shard: the same command with --shard I/N --out DIR, I from 1 to N. Run again\n"
      "it goes on with what is missing. docs/shards.md");
  return {app, [o, run_words](const std::string&) {
            const shards::ShardHead head = shards::read_shard_head(shards::shard_path(o->folders.front()));
            std::vector<std::string> words = words_of(head.command);
            const std::string command = words.size() > 1 ? words[1] : "";
            // A file must not make this program do something else.
            if (command != "evaluate" && command != "compare")
              throw input_error(
                  shards::shard_path(o->folders.front()), 0,
                  "expected a shard of evaluate or compare, found one of '" + printable(head.command) + "'");
            if (o->json && command == "compare")
              throw Error(ErrorKind::usage,
                          "--json: compare prints no JSON; expected --out DIR, where compare.json goes");
            for (const std::string& folder : o->folders) words.insert(words.end(), {"--merged", folder});
            if (!o->out.empty()) words.insert(words.end(), {"--out", o->out});
            if (o->json) words.push_back("--json");
            if (o->quiet) words.push_back("--quiet");
            return run_words(words);
          }};
}

}  // namespace parloc::tools
