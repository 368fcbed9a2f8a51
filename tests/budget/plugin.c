/* SPDX-License-Identifier: MIT */
/* A QEMU plugin that counts the instructions of every function, callees included, by class of event (docs/results/budget.md).
 *
 *   -plugin libbudget_plugin.so,symbols=NM.txt,groups=GROUPS.txt,cycles=CYCLES.txt,out=FILE.csv
 *
 * NM.txt is what `nm -S` says of the image, GROUPS.txt has lines "group function". A group counts while any of its functions is
 * under way, so a function that calls another one of its group counts once. An event ends with a call of budget_class_N, which
 * says what class it was. CYCLES.txt has lines "address slow more-when-it-branches quick more" in cycles of a model (cycles.py)
 * for all that is executed; without it all are 0. Written for the plugin interface 1 of QEMU 7.2, whose header Debian does not
 * package. */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define EXPORT __attribute__((visibility("default")))
typedef uint64_t plugin_id_t;
struct qemu_plugin_tb;
struct qemu_plugin_insn;
void qemu_plugin_register_vcpu_tb_trans_cb(plugin_id_t id, void (*translated)(plugin_id_t, struct qemu_plugin_tb *));
void qemu_plugin_register_vcpu_insn_exec_cb(struct qemu_plugin_insn *insn, void (*run)(unsigned, void *), int flags, void *user);
void qemu_plugin_register_atexit_cb(plugin_id_t id, void (*ended)(plugin_id_t, void *), void *user);
size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb *tb);
struct qemu_plugin_insn *qemu_plugin_tb_get_insn(const struct qemu_plugin_tb *tb, size_t index);
uint64_t qemu_plugin_insn_vaddr(const struct qemu_plugin_insn *insn);
size_t qemu_plugin_insn_size(const struct qemu_plugin_insn *insn);
const void *qemu_plugin_insn_data(const struct qemu_plugin_insn *insn);
EXPORT int qemu_plugin_version = 1;

enum { CLASSES = 24, ITEMS_MAX = 4096, DEPTH_MAX = 256, CODE_BYTES = 4 << 20, NAME_MAX_BYTES = 96, NONE = -1 };

/* A function or a group of them. */
typedef struct item {
    char name[NAME_MAX_BYTES];
    uint64_t started, started_slow, started_quick; /* Counts when the outermost call began. */
    int open;         /* Calls under way. */
    uint64_t event_calls, event_count, event_slow, event_quick; /* In the event under way. */
    struct { uint64_t events, calls, total, most, slow, most_slow, quick, most_quick; } of[CLASSES];
} item_t;

typedef struct function {
    uint32_t first, end; /* Addresses. */
    int item, group;     /* Indices; NONE. */
    int event_class;     /* Of budget_class_N; NONE. */
} function_t;

typedef struct instruction {
    uint32_t pc, after;
    bool is_call;
    int entry, within; /* Function that begins here, function it is of; NONE. */
    struct costs { uint8_t slow, slow_branch, quick, quick_branch; } costs; /* Of the model; branch: when the next one is elsewhere. */
} instruction_t;

static item_t items[ITEMS_MAX];
static function_t functions[ITEMS_MAX];
static int item_count, group_count, function_count;
static instruction_t *code[CODE_BYTES / 2];
static struct { int function; uint32_t back; } stack[DEPTH_MAX];
static int depth;
static uint64_t executed, slow, quick;
static bool has_cycles;
static struct costs costs[CODE_BYTES / 2];
static const instruction_t *before;
static char out_name[512];

/* ---- calls ----------------------------------------------------------------------------------------------------- */

static void open_item(int index) {
    if (index == NONE) { return; }
    item_t *item = &items[index];
    if (item->open++ == 0) { item->started = executed, item->started_slow = slow, item->started_quick = quick; }
    item->event_calls++;
}

static void close_item(int index) {
    if (index == NONE) { return; }
    item_t *item = &items[index];
    if (--item->open > 0) { return; }
    item->event_count += executed - item->started;
    item->event_slow += slow - item->started_slow;
    item->event_quick += quick - item->started_quick;
}

static void enter(int function, uint32_t back) {
    if (depth == DEPTH_MAX) { fprintf(stderr, "budget plugin: calls nest too deep\n"); exit(1); }
    stack[depth].function = function;
    stack[depth++].back = back;
    if (function == NONE) { return; }
    open_item(functions[function].item);
    open_item(functions[function].group);
}

static void leave(void) {
    const int function = stack[--depth].function;
    if (function == NONE) { return; }
    close_item(functions[function].item);
    close_item(functions[function].group);
}

/* Some functions of the compiler's library return past their caller, to its caller. Nothing here is recursive, so an address that a
 * call under way returns to is reached only by returning. */
static void return_to(uint32_t pc) {
    for (int i = depth - 1; i >= 0; i--) {
        if (stack[i].back != pc) { continue; }
        while (depth > i) { leave(); }
    }
}

static void raise_to(uint64_t *most, uint64_t count) {
    if (count > *most) { *most = count; }
}

static void end_event(int event_class) {
    for (int i = 0; i < item_count; i++) {
        item_t *item = &items[i];
        if (item->event_calls == 0) { continue; }
        item->of[event_class].events++;
        item->of[event_class].calls += item->event_calls;
        item->of[event_class].total += item->event_count;
        item->of[event_class].slow += item->event_slow;
        item->of[event_class].quick += item->event_quick;
        raise_to(&item->of[event_class].most, item->event_count);
        raise_to(&item->of[event_class].most_slow, item->event_slow);
        raise_to(&item->of[event_class].most_quick, item->event_quick);
        item->event_calls = item->event_count = item->event_slow = item->event_quick = 0;
    }
}

/* A jump to the begin of another function is a call that returns to where the present one does. A call may also go to what
 * has no symbol of its own, as in the compiler's library. */
static void on_instruction(unsigned cpu, void *user) {
    (void)cpu;
    const instruction_t *now = user;
    if (before != NULL && now->pc != before->after) {
        slow += before->costs.slow_branch;
        quick += before->costs.quick_branch;
        return_to(now->pc);
        const bool begins = now->entry != NONE;
        if (before->is_call) { enter(now->entry, before->after); }
        else if (begins && before->within != now->entry && depth > 0) { enter(now->entry, stack[depth - 1].back); }
        if (begins && functions[now->entry].event_class != NONE) { end_event(functions[now->entry].event_class); }
    }
    executed++;
    slow += now->costs.slow;
    quick += now->costs.quick;
    before = now;
}

/* ---- code ------------------------------------------------------------------------------------------------------ */

static int function_at(uint32_t pc) {
    for (int i = 0; i < function_count; i++) {
        if (pc >= functions[i].first && pc < functions[i].end) { return i; }
    }
    return NONE;
}

/* BLX register, or the long BL. */
static bool calls(const void *bytes, size_t size) {
    uint16_t half[2] = { 0, 0 };
    memcpy(half, bytes, size);
    if (size == 2) { return (half[0] & 0xff87u) == 0x4780u; }
    return (half[0] & 0xf800u) == 0xf000u && (half[1] & 0xd000u) == 0xd000u;
}

static instruction_t *instruction_of(const struct qemu_plugin_insn *insn) {
    const uint32_t pc = (uint32_t)qemu_plugin_insn_vaddr(insn);
    if (pc >= CODE_BYTES) { fprintf(stderr, "budget plugin: code outside the ROM\n"); exit(1); }
    if (code[pc / 2] == NULL) {
        const size_t size = qemu_plugin_insn_size(insn);
        const int within = function_at(pc);
        if (has_cycles && costs[pc / 2].slow == 0) { fprintf(stderr, "budget plugin: no cycles for what stands at %x\n", pc); exit(1); }
        instruction_t *made = calloc(1, sizeof *made);
        *made = (instruction_t){ .pc = pc, .after = pc + (uint32_t)size, .is_call = calls(qemu_plugin_insn_data(insn), size),
                                 .costs = costs[pc / 2],
                                 .within = within, .entry = (within != NONE && functions[within].first == pc) ? within : NONE };
        code[pc / 2] = made;
    }
    return code[pc / 2];
}

static void on_translation(plugin_id_t id, struct qemu_plugin_tb *tb) {
    (void)id;
    const size_t count = qemu_plugin_tb_n_insns(tb);
    for (size_t i = 0; i < count; i++) {
        struct qemu_plugin_insn *insn = qemu_plugin_tb_get_insn(tb, i);
        qemu_plugin_register_vcpu_insn_exec_cb(insn, on_instruction, 0, instruction_of(insn));
    }
}

/* ---- files ----------------------------------------------------------------------------------------------------- */

static FILE *open_file(const char *name, const char *mode) {
    FILE *file = (name != NULL) ? fopen(name, mode) : NULL;
    if (file == NULL) { fprintf(stderr, "budget plugin: %s cannot be opened\n", (name != NULL) ? name : "a file not named"); exit(1); }
    return file;
}

/* The one of that name between two indices, or a new one. */
static int item_named(const char *name, int from, int to) {
    for (int i = from; i < to; i++) {
        if (strcmp(items[i].name, name) == 0) { return i; }
    }
    if (item_count == ITEMS_MAX) { fprintf(stderr, "budget plugin: too many functions\n"); exit(1); }
    snprintf(items[item_count].name, NAME_MAX_BYTES, "%s", name);
    return item_count++;
}

static struct { char function[NAME_MAX_BYTES]; int group; } members[ITEMS_MAX];
static int member_count;

static void read_groups(const char *name) {
    FILE *file = open_file(name, "r");
    char group[NAME_MAX_BYTES];
    while (member_count < ITEMS_MAX && fscanf(file, "%95s %95s", group, members[member_count].function) == 2) {
        members[member_count++].group = item_named(group, 0, item_count);
    }
    fclose(file);
    group_count = item_count;
}

static void read_cycles(const char *name) {
    if (name == NULL) { return; }
    FILE *file = open_file(name, "r");
    unsigned address, of[4];
    while (fscanf(file, "%x %u %u %u %u", &address, &of[0], &of[1], &of[2], &of[3]) == 5) {
        if (address >= CODE_BYTES || (of[0] | of[1] | of[2] | of[3]) > UINT8_MAX) {
            fprintf(stderr, "budget plugin: cycles of %x\n", address);
            exit(1);
        }
        costs[address / 2] = (struct costs){ (uint8_t)of[0], (uint8_t)of[1], (uint8_t)of[2], (uint8_t)of[3] };
    }
    fclose(file);
    has_cycles = true;
}

static int group_of(const char *function) {
    for (int i = 0; i < member_count; i++) {
        if (strcmp(members[i].function, function) == 0) { return members[i].group; }
    }
    return NONE;
}

/* Clones that the compiler makes, name.part.0 and the like, are the function they come from. */
static void read_symbols(const char *name) {
    FILE *file = open_file(name, "r");
    char line[256], symbol[NAME_MAX_BYTES], type;
    unsigned address, size;
    while (fgets(line, sizeof line, file) != NULL && function_count < ITEMS_MAX) {
        if (sscanf(line, "%x %x %c %95s", &address, &size, &type, symbol) != 4 || strchr("tTwW", type) == NULL) { continue; }
        symbol[strcspn(symbol, ".")] = 0;
        function_t *function = &functions[function_count++];
        *function = (function_t){ .first = address & ~1u, .end = (address & ~1u) + size, .event_class = NONE };
        function->item = item_named(symbol, group_count, item_count);
        function->group = group_of(symbol);
        if (sscanf(symbol, "budget_class_%d", &function->event_class) == 1 && function->event_class >= CLASSES) { exit(1); }
    }
    fclose(file);
}

static void write_counts(plugin_id_t id, void *user) {
    (void)id, (void)user;
    FILE *file = open_file(out_name, "w");
    fprintf(file, "kind,name,class,events,calls,total,most,slow,most_slow,quick,most_quick\n");
    for (int i = 0; i < item_count; i++) {
        for (int c = 0; c < CLASSES; c++) {
            if (items[i].of[c].events == 0) { continue; }
            fprintf(file, "%s,%s,%d,%llu,%llu,%llu,%llu,%llu,%llu,%llu,%llu\n", (i < group_count) ? "group" : "function", items[i].name, c,
                    (unsigned long long)items[i].of[c].events, (unsigned long long)items[i].of[c].calls,
                    (unsigned long long)items[i].of[c].total, (unsigned long long)items[i].of[c].most,
                    (unsigned long long)items[i].of[c].slow, (unsigned long long)items[i].of[c].most_slow,
                    (unsigned long long)items[i].of[c].quick, (unsigned long long)items[i].of[c].most_quick);
        }
    }
    fclose(file);
}

EXPORT int qemu_plugin_install(plugin_id_t id, const void *info, int count, char **arguments) {
    (void)info;
    const char *symbols = NULL, *groups = NULL, *model = NULL;
    for (int i = 0; i < count; i++) {
        if (strncmp(arguments[i], "symbols=", 8) == 0) { symbols = arguments[i] + 8; }
        if (strncmp(arguments[i], "groups=", 7) == 0) { groups = arguments[i] + 7; }
        if (strncmp(arguments[i], "cycles=", 7) == 0) { model = arguments[i] + 7; }
        if (strncmp(arguments[i], "out=", 4) == 0) { snprintf(out_name, sizeof out_name, "%s", arguments[i] + 4); }
    }
    read_groups(groups);
    read_symbols(symbols);
    read_cycles(model);
    qemu_plugin_register_vcpu_tb_trans_cb(id, on_translation);
    qemu_plugin_register_atexit_cb(id, write_counts, NULL);
    return 0;
}
