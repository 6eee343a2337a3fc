// The result of a batch that has ended, for the user.
#pragma once

#include <string>

#include "app/support/batch_options.h"
#include "app/support/report_page.h"
#include "experiments/system/terminal.h"

namespace firn {

// Writes the page of the batch and prints its result, as JSON or as a table with a line on standard
// error that names `files` and the page. `Result` has a `directory`, render_json() and
// render_table().
template <class Result>
void print_batch_result(const BatchArguments& arguments, const Result& result,
                        const std::string& files) {
  const std::string page = write_folder_page(result.directory);
  if (arguments.json) {
    print_lines(stdout, "{}\n", render_json(result));
    return;
  }
  print_lines(stdout, "{}", render_table(result));
  print_lines(stderr, "{}{}\n", files, page.empty() ? "" : "; to be read: " + page);
}

}  // namespace firn
