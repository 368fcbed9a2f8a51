// SPDX-License-Identifier: MIT
#include "studies/afr/afr_study.hpp"

#include <algorithm>
#include <functional>

#include "common/error.hpp"
#include "common/progress.hpp"
#include "studies/afr/afr_parts.hpp"

namespace sixdeg {
namespace {

/// What a whole study makes of its seeds, and how many a part alone takes by itself.
struct Part {
    const char *name;
    std::function<void(int, int)> print;
    std::function<int(int)> share;
    int alone;
};

const std::vector<Part> &parts() {
    using namespace afr_study;
    const auto all = [](int seeds) { return seeds; };
    const auto fifth = [](int seeds) { return std::max(seeds / 5, 1); };
    static const std::vector<Part> list{{"accuracy", accuracy, all, 100},
                                        {"blame", blames, [](int seeds) { return 4 * seeds; }, 400},
                                        {"stated", doubts, all, 100},
                                        {"egr", [](int seeds, int) { recirculation(seeds); }, all, 100},
                                        {"ghosts", [](int, int) { ghosts(); }, all, 1},
                                        {"chain", [](int seeds, int) { chain(seeds); }, fifth, 20},
                                        {"pressure", [](int, int) { pressure(); }, all, 1}};
    return list;
}

} // namespace

std::vector<std::string> afr_study_parts() {
    std::vector<std::string> names;
    for (const Part &part : parts()) names.push_back(part.name);
    names.push_back("readings");
    return names;
}

void print_afr_study(const std::string &part, int seeds, int cases) {
    if (part == "readings") return afr_study::readings();
    Progress progress("part", part.empty() ? double(parts().size()) : 1);
    for (const Part &p : parts()) {
        if (part.empty()) p.print(p.share(seeds > 0 ? seeds : 100), cases), progress.next();
        else if (part == p.name) p.print(seeds > 0 ? seeds : p.alone, cases);
    }
}

} // namespace sixdeg
