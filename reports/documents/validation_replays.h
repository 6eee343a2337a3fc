// One replay of each experiment on the page of a validation.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "reports/html/page.h"
#include "validation/validation_document.h"

namespace firn {

class ValidationReplays {
 public:
  // `folder`: where the results.json lay. `budget`: characters of data over all replays.
  ValidationReplays(const ValidationDocument& results, const std::string& folder,
                    std::size_t budget);

  // The replay of the experiment's first run (its first parameter set, first seed), where its
  // results file is still there; for a further comparison (at `anchor`) of the same experiment a
  // link to it.
  void add(const std::string& experiment, const std::string& anchor, page::Page& page,
           page::Content& content);

 private:
  struct FirstRun {
    std::string file, shown_as, parameter_set;
    std::uint64_t seed = 0;
    std::string drawn_at;  // anchor of the comparison that has the replay; empty: none yet
  };

  std::map<std::string, FirstRun> runs_;  // by experiment, of those that are compared
  std::size_t budget_, waiting_;  // remaining characters, and number of remaining experiments
};

}  // namespace firn
