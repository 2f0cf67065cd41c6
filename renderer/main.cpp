// equilux-render: makes stimuli.
#include "base/program.h"
#include "base/version.h"
#include "renderer/commands.h"
#include "renderer/isa.h"
#include "renderer/parallel.h"

int main(int argc, char** argv) {
  using namespace equilux;
  CLI::App app("Makes stimuli: path-traced references and VPL pictures of a study's conditions",
               "equilux-render");
  app.set_version_flag("--version", std::string("equilux-render ") + kVersion);
  app.require_subcommand(1);
  app.footer("Example: equilux-render set protocols/pocket.json --out studies/pocket");
  CommandLine line;
  add_set(app, line);
  add_plan(app, line);
  add_gather(app, line);
  add_submit(app, line);
  add_verify(app, line);
  add_image(app, line);
  add_tonemap(app, line);
  add_prove(app, line);
  add_stress(app, line);
  add_describe(app, line);
  add_export(app, line);
  add_sheet(app, line);
  add_converge(app, line);
  add_explain(app, line);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kExitOk : kExitUsage;
  }
  return run_program("equilux-render", [&] {
    const ThreadLimit limit(line.threads);
    if (!line.isa.empty()) fix_isa(parse_isa(line.isa, "--isa"));
    return line.command();
  });
}
