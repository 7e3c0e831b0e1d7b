/* Calls every function of a family with all kinds of arguments: every LIBRARY [planted NAME]
 *
 * For the address sanitizer and memcheck, or without either. Arguments are in memory of exactly the
 * size declared in the headers, so that an access one byte beyond is detected. The memory is freed
 * after the call, so that a late write is detected too. Checked here: a code of the interface; 0 and
 * zeros from functions that do not concern this arm; 3 for a null pointer in place of a value; and
 * unchanged results unless 0 was returned.
 *
 * With `planted`, the function of that name gets memory one byte too short, which the tool must
 * report.
 */
#include "library.h"

enum kind { Host, Command, Guarded, Neutral };

struct call {
    const char *name;
    enum kind kind;
    int (*call)(void);
};

/* Kinds of arguments. */
enum way {
    PLAIN,  /* zeros and small numbers */
    ODD,    /* the same at odd addresses */
    NOISE,  /* random bytes and numbers */
    BORDER, /* extreme numbers, long texts */
    NULLS,  /* null for every pointer */
    WAYS
};
static const char *const WAY[] = {"plain", "odd", "noise", "border", "nulls"};

static library from;
static int who;
static bool who_is_there;
static enum way way;
static bool short_by_one;

/* Arguments of the current call. */
static struct {
    unsigned char *start, *at;
    size_t size;
    bool result, index, asked;
} parts[16];
static int used;
static bool value_is_null;
static size_t result_bytes;

static uint32_t seed = 1;

static uint32_t noise(void) {
    seed ^= seed << 13;
    seed ^= seed >> 17;
    return seed ^= seed << 5;
}

static void *part(size_t size, bool result, bool index) {
    if (way == NULLS) {
        value_is_null = value_is_null || !index;
        return NULL;
    }
    size_t shift = way == ODD;
    size_t got = size - (short_by_one && size > 0 && result ? 1 : 0);
    unsigned char *start = malloc(got + shift);
    if (!start && got + shift > 0) {
        exit(9);
    }
    memset(start + shift, result ? 0xA5 : 0, got);
    for (size_t at = 0; !result && way == NOISE && at < got; at++) {
        start[shift + at] = (unsigned char)noise();
    }
    parts[used].start = start;
    parts[used].at = start + shift;
    parts[used].size = got;
    parts[used].result = result;
    parts[used].index = index;
    parts[used].asked = false;
    used++;
    return start + shift;
}

/* Memory that the function reads. */
static void *new_given(size_t size) {
    bool was = short_by_one;
    unsigned char *made;
    if (!was) {
        return part(size, false, false);
    }
    made = part(size - 1, false, false);
    return made;
}

/* Memory that the function writes. */
static void *new_wanted(size_t size) {
    unsigned char *made = part(size, true, false);
    result_bytes += made ? size : 0;
    return made;
}

/* The same for a structure whose first byte is an input that selects the pin: the first, or any. */
static void *new_asked(size_t size) {
    unsigned char *made = new_wanted(size);
    if (made && size > 1) {
        *made = way == NOISE ? (unsigned char)noise() : way == BORDER ? 255 : 1;
        parts[used - 1].asked = true;
    }
    return made;
}

static void *new_index(void) {
    return part(sizeof(uint64_t), true, true);
}

static void *new_listed(size_t size, int count) {
    /* Too many for any memory: the function must check the count before it accesses them. */
    bool sane = count >= 0 && count <= 64;
    return part(size * (sane ? (size_t)count : 1), false, false);
}

static int new_count(void) {
    static const int counts[] = {0, 1, 2, 64, -1, 1000, 0x7FFFFFFF, (int)0x80000000};
    return way == NOISE || way == BORDER ? counts[noise() % 8] : 2;
}

/* Size of a buffer as passed to the function. */
static uint32_t new_room(void) {
    static const uint32_t rooms[] = {0, 1, 2, 3, 15, 16, 17, 255, 0xFFFFFFFF, 0x80000000};
    return short_by_one ? 1 : way == NOISE || way == BORDER ? rooms[noise() % 10] : 32;
}

/* Actual size: limited to this, as no result is longer. */
static size_t fits(uint32_t said) {
    return said < 8192 ? said : 8192;
}

static const char *new_text(void) {
    static const int lengths[] = {0, 1, 20, 100, 168, 255, 256, 4000};
    int length = way == NOISE || way == BORDER ? lengths[noise() % 8] : 4;
    bool was = short_by_one;
    if (way == NULLS) {
        return NULL;
    }
    short_by_one = false;
    char *made = part((size_t)length + 1, false, false);
    short_by_one = was;
    for (int at = 0; made && at < length; at++) {
        made[at] = way == NOISE ? (char)(1 + noise() % 255) : 'a';
    }
    if (made) {
        made[length] = 0;
    }
    return made;
}

static float new_real(void) {
    static const uint32_t reals[] = {0x7F800000, 0xFF800000, 0x7FC00000, 0x7F7FFFFF, 1, 0x80000000};
    uint32_t bits = way == BORDER ? reals[noise() % 6] : way == NOISE ? noise() : 0;
    float made;
    memcpy(&made, &bits, sizeof made);
    return made;
}

static uint32_t new_whole(void) {
    static const uint32_t wholes[] = {0, 1, 2, 127, 128, 255, 256, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF};
    return way == BORDER ? wholes[noise() % 10] : way == NOISE ? noise() : 1;
}

#include "calls.h"

static int wrong;

static void complain(const struct call *of, int code, const char *about) {
    printf("  FAIL %s, %s: %s (returned %d)\n", of->name, WAY[way], about, code);
    wrong++;
}

/* True if all results consist of one repeated byte. */
static bool all(unsigned char byte, bool with_index) {
    for (int at = 0; at < used; at++) {
        for (size_t place = parts[at].asked; parts[at].result && (with_index || !parts[at].index) && place < parts[at].size; place++) {
            if (parts[at].at[place] != byte) {
                return false;
            }
        }
    }
    return true;
}

static void look(const struct call *of, int code) {
    bool counts = strcmp(of->name, "SearchDobot") == 0 || strcmp(of->name, "MagicianLastError") == 0;
    if (counts ? code < 0 : code < 0 || code > 4) {
        complain(of, code, "not a code of the interface");
    }
    if (of->kind == Neutral && code != 0) {
        complain(of, code, "what is not for this arm has to return 0");
    }
    if (of->kind == Neutral && !all(0, false)) {
        complain(of, code, "what is not for this arm has to give zeros");
    }
    if (of->kind == Command && value_is_null && code != 3) {
        complain(of, code, "a null pointer where a value belongs has to return 3");
    }
    if (of->kind == Command && way <= ODD && code != 0) {
        complain(of, code, "has to return 0");
    }
    if (of->kind != Host && code != 0 && !all(0xA5, true)) {
        complain(of, code, "a result was written though 0 was not returned");
    }
    if (of->kind == Command && way <= ODD && code == 0 && result_bytes > 0 && all(0xA5, false)) {
        complain(of, code, "no result was written though 0 was returned");
    }
}

static int codes[6];

static void one(const struct call *of) {
    used = 0;
    value_is_null = false;
    result_bytes = 0;
    int code = of->call();
    look(of, code);
    codes[code >= 0 && code < 5 ? code : 5]++;
    for (int at = 0; at < used; at++) {
        free(parts[at].start);
    }
}

/* Prepares the arm to accept commands, in whatever state the previous ones left it. */
static void calm(void) {
    OF(from, SetCmdTimeout)(MASTER(who) 300);
    OF(from, ClearAllAlarmsState)(ONLY(who));
    OF(from, SetQueuedCmdStopDownload)(ONLY(who));
    OF(from, SetQueuedCmdClear)(ONLY(who));
    OF(from, SetQueuedCmdStartExec)(ONLY(who));
}

/* Functions that would end the session or slow the program down. */
static bool skipped(const char *name) {
    static const char *const once_connected[] = {"ConnectDobot", "DisconnectDobot", "SearchDobot"};
    for (int at = 0; at < 3; at++) {
        if (who_is_there && strcmp(name, once_connected[at]) == 0) {
            return true;
        }
    }
    return strcmp(name, "DobotSleep") == 0;
}

int main(int count, char **words) {
    if (count < 2) {
        fprintf(stderr, "every LIBRARY [planted NAME]\n");
        return 2;
    }
    const char *planted = count > 3 ? words[3] : NULL;
    from = open_library(words[1]);
    size_t functions = sizeof CALLS / sizeof *CALLS;

    /* Before a connection exists. A null name connects to MAGICIAN_PORT, and remains connected in
     * families with ids. */
    for (way = 0; way < WAYS && !planted; way++) {
        for (size_t at = 0; at < functions; at++) {
            if (!skipped(CALLS[at].name) && CALLS[at].kind == Host) {
                one(&CALLS[at]);
            }
        }
    }
    OF(from, SetCmdTimeout)(MASTER(0) 300);
    if (connect_arm(from, "sim", &who) != 0) {
        fprintf(stderr, "no connection\n");
        return 1;
    }
    who_is_there = true;
    for (way = 0; way < WAYS; way++) {
        for (size_t at = 0; at < functions; at++) {
            bool is_planted = planted && strcmp(CALLS[at].name, planted) == 0;
            if (skipped(CALLS[at].name) || (planted && !is_planted)) {
                continue;
            }
            if (at % 8 == 0 || planted) {
                calm();
            }
            short_by_one = is_planted;
            one(&CALLS[at]);
            short_by_one = false;
        }
    }
    int left = OF(from, DisconnectDobot)(ONLY_MASTER(who));

    /* And after the connection has ended. */
    for (way = NOISE; way < WAYS && !planted; way++) {
        for (size_t at = 0; at < functions; at++) {
            if (!skipped(CALLS[at].name)) {
                used = 0;
                int code = CALLS[at].call();
                if (CALLS[at].kind == Command && code == 0) {
                    complain(&CALLS[at], code, "0 without an arm");
                }
                for (int part_at = 0; part_at < used; part_at++) {
                    free(parts[part_at].start);
                }
            }
        }
    }
    printf("%zu functions; returned 0 %d times, 1 %d, 2 %d, 3 %d, 4 %d, more %d; %d wrong\n", functions, codes[0], codes[1],
           codes[2], codes[3], codes[4], codes[5], wrong);
    return wrong || left ? 1 : 0;
}
