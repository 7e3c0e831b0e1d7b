/* Measures the duration of calls: rate LIBRARY PORT GETS MOVES. Prints the seconds of each batch.
 * `cargo xtask bench door` runs it.
 *
 * A line on stdin starts a batch, `g` for GetPose and `m` for SetPTPCmd. The library is connected
 * only during a batch, so that another driver can alternate on the same line.
 */
#include "library.h"

#include <time.h>

static double seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + (double)now.tv_nsec / 1e9;
}

static int gets(library from, int who, int count) {
    (void)who;
    __typeof__(&GetPose) get_pose = OF(from, GetPose);
    int wrong = 0;
    for (int at = 0; at < count; at++) {
        Pose pose;
        wrong += get_pose(ARM(who) &pose) != 0;
    }
    return wrong;
}

static int moves(library from, int who, int count) {
    (void)who;
    __typeof__(&SetPTPCmd) set_ptp = OF(from, SetPTPCmd);
    int wrong = 0;
    for (int at = 0; at < count; at++) {
        PTPCmd move = {2, 200, at % 2 ? 1 : -1, 50, 0};
        uint64_t index = 0;
        wrong += set_ptp(ARM(who) &move, true, &index) != 0;
    }
    return wrong;
}

int main(int count, char **words) {
    if (count != 5) {
        fprintf(stderr, "rate LIBRARY PORT GETS MOVES\n");
        return 2;
    }
    library from = open_library(words[1]);
    int get_count = atoi(words[3]), move_count = atoi(words[4]);
    for (char line[8]; fgets(line, sizeof line, stdin);) {
        int who, wrong = connect_arm(from, words[2], &who);
        wrong += OF(from, SetQueuedCmdStartExec)(ONLY(who));
        wrong += *line == 'g' ? gets(from, who, 10) : moves(from, who, 10);
        double began = seconds();
        wrong += *line == 'g' ? gets(from, who, get_count) : moves(from, who, move_count);
        double took = seconds() - began;
        wrong += OF(from, DisconnectDobot)(ONLY_MASTER(who));
        if (wrong) {
            fprintf(stderr, "%d calls did not return 0\n", wrong);
            return 1;
        }
        printf("%.9f\n", took);
        fflush(stdout);
    }
    return 0;
}
