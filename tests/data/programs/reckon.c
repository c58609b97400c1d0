/* An estimator in C: dead reckoning from odometry. Build it with: cc -O2 -o reckon reckon.c -lm */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Return the number after a key, from `from` on; JSON keys come in the order of the page of the docs. */
static double number_after(const char *from, const char *key) {
    const char *found = from ? strstr(from, key) : NULL;
    return found ? strtod(found + strlen(key), NULL) : 0.0;
}

/* Read up to `count` numbers of the nested list after a key. */
static void numbers_after(const char *from, const char *key, double *numbers, int count) {
    const char *at = from ? strstr(from, key) : NULL;
    char *end;
    if (!at) return;
    for (at += strlen(key); count > 0 && *at; at = end) {
        *numbers = strtod(at, &end);
        if (end == at) end++;              /* a bracket or a comma */
        else numbers++, count--;
    }
}

int main(int argc, char **argv) {
    double pose[3] = {0}, P[9] = {0}, Q[9], F[9], T[9];
    double scale = argc > 1 ? atof(argv[1]) : 1.0;   /* of the distance driven, to show arguments */
    char *line = NULL;
    size_t room = 0;
    while (getline(&line, &room, stdin) > 0) {
        if (strstr(line, "{\"call\":\"start\"") == line) {
            numbers_after(line, "\"prior\":", pose, 3);
            numbers_after(line, "\"prior_covariance\":", P, 9);
            puts("{}");
        } else {
            const char *odometry = strstr(line, "\"odometry\":");
            double f = scale * number_after(odometry, "\"forward\":"), l = number_after(odometry, "\"left\":");
            double turn = number_after(odometry, "\"turn\":"), c = cos(pose[2]), s = sin(pose[2]);
            numbers_after(odometry, "\"covariance\":", Q, 9);
            double dx = c * f - s * l, dy = s * f + c * l;
            double A[9] = {1, 0, -dy, 0, 1, dx, 0, 0, 1}, G[9] = {c, -s, 0, s, c, 0, 0, 0, 1};
            for (int i = 0; i < 9; i++) {  /* P = A P A' + G Q G' */
                F[i] = T[i] = 0;
                for (int k = 0; k < 3; k++) {
                    F[i] += A[i / 3 * 3 + k] * P[k * 3 + i % 3];
                    T[i] += G[i / 3 * 3 + k] * Q[k * 3 + i % 3];
                }
            }
            for (int i = 0; i < 9; i++) {
                P[i] = 0;
                for (int k = 0; k < 3; k++) P[i] += F[i / 3 * 3 + k] * A[i % 3 * 3 + k] + T[i / 3 * 3 + k] * G[i % 3 * 3 + k];
            }
            pose[0] += dx, pose[1] += dy, pose[2] += turn;
            printf("{\"pose\":[%.17g,%.17g,%.17g],\"covariance\":[[%.17g,%.17g,%.17g],[%.17g,%.17g,%.17g],[%.17g,%.17g,%.17g]]}\n",
                   pose[0], pose[1], pose[2], P[0], P[1], P[2], P[3], P[4], P[5], P[6], P[7], P[8]);
        }
        fflush(stdout);                    /* else the answer waits in a buffer, and the simulator for it */
    }
    free(line);
    return 0;
}
